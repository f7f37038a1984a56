#include "haptics/points/FittedLevel.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/dense/QuasiNewton.h"

#include <algorithm>

namespace midair::haptics
{

namespace
{

constexpr int kDefaultIterations = 300;
constexpr int kMemory = 8;        // number of stored steps
constexpr int kMaxHalvings = 20;  // maximum number of halvings of a step in the line search
constexpr double kArmijo = 1e-4;  // required fall of the cost, as a share of the linear model's
constexpr double kStalled = 1e-4; // relative fall of the cost in ten steps that counts as stalled
// Requested loudness E, a little below the 0.9 to 1.3 of unit amplitudes, so that the targets can
// be met exactly.
constexpr double kAim = 0.8;

/// Gradient descent on the transducers' phases phi (unit amplitudes) by L-BFGS (Nocedal, Wright,
/// "Numerical optimization", algorithms 7.4 and 3.1), as Andersson, "levitate" (2019), has it:
///     f = 1/2 sum_l (|p_l| / s - a_l)^2,  df/dphi_i = -Im(q_i conj(z_i)),
///     z = G* (r u) / s,  r_l = |p_l| / s - a_l.
/// A cost reads G once, and so does a gradient.
class Lbfgs final : public SolverBase
{
public:
    explicit Lbfgs(const SolverOptions& options) : SolverBase("lbfgs", options) {}

private:
    Outcome iterate(FieldProblem& field, bool /*warm*/) override
    {
        start(field);
        Outcome outcome;
        const int limit = iterationLimit(kDefaultIterations);
        double before = _cost;
        while (outcome.iterations < limit && outcome.stop == StopReason::MAX_ITERATIONS)
        {
            const auto s = static_cast<double>(fittedLevel(field.y, field.a));
            if (relativeErrors(field.y, field.a, s).rms <= options().rmsTolerance)
            {
                outcome.stop = StopReason::CONVERGED;
                break;
            }
            if (!step(field)) outcome.stop = StopReason::STALLED;
            ++outcome.iterations;
            if (outcome.iterations % 10 == 0)
            {
                if (before - _cost <= kStalled * before) outcome.stop = StopReason::STALLED;
                before = _cost;
            }
            if (outOfTime(field)) outcome.stop = StopReason::DEADLINE;
        }
        return outcome;
    }

    // Starts from the transducers' phases that follow from the points' phases.
    void start(FieldProblem& field)
    {
        const int m = field.m();
        _scale = kAim * field.meanRowSum() / static_cast<double>(field.a.norm());
        for (int l = 0; l < field.n(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            field.w.set(row, field.u.at(row) * field.a[l]);
        }
        field.backward(field.w, field.z);
        _phi.resize(m);
        for (int i = 0; i < m; ++i)
            _phi[i] = std::arg(field.z.at(static_cast<std::size_t>(i)));
        _descent.forget();
        _cost = cost(field, _phi);
        gradient(field, _gradient);
    }

    // Returns f at \a phi and sets field.q, p = G q, y and u.
    double cost(FieldProblem& field, const Eigen::VectorXf& phi) const
    {
        for (int i = 0; i < field.m(); ++i)
            field.q.set(static_cast<std::size_t>(i), std::polar(1.0f, phi[i]));
        field.forward(field.q, field.p);
        field.phasesOf(field.p);
        double sum = 0.0;
        for (int l = 0; l < field.n(); ++l)
        {
            const double r = field.y[l] / _scale - field.a[l];
            sum += r * r;
        }
        return 0.5 * sum;
    }

    // Computes the gradient at the field of the last cost().
    void gradient(FieldProblem& field, Eigen::VectorXf& result) const
    {
        for (int l = 0; l < field.n(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            const double r = field.y[l] / _scale - field.a[l];
            field.w.set(row, field.u.at(row) * static_cast<float>(r / _scale));
        }
        field.backward(field.w, field.z);
        result.resize(field.m());
        for (int i = 0; i < field.m(); ++i)
        {
            const auto s = static_cast<std::size_t>(i);
            result[i] = -(field.q.im[s] * field.z.re[s] - field.q.re[s] * field.z.im[s]);
        }
    }

    void direct()
    {
        _descent.direct(_gradient, _direction);
        // A step to zero cost if it fell at a constant rate.
        if (_descent.isEmpty())
            _direction *= static_cast<float>(
                _cost / std::max(1e-30, static_cast<double>(_gradient.squaredNorm())));
    }

    // Takes one step. Returns false, with the field unchanged, if the cost no longer falls.
    bool step(FieldProblem& field)
    {
        direct();
        double slope = static_cast<double>(_direction.dot(_gradient));
        if (!(slope < 0.0))
        {
            _descent.forget();
            direct();
            slope = static_cast<double>(_direction.dot(_gradient));
        }
        double length = 1.0;
        for (int halving = 0; halving < kMaxHalvings && slope < 0.0; ++halving, length *= 0.5)
        {
            _tried = _phi + static_cast<float>(length) * _direction;
            const double tried = cost(field, _tried);
            if (!(tried <= _cost + kArmijo * length * slope)) continue;
            accept(field, tried, static_cast<float>(length));
            return true;
        }
        cost(field, _phi);
        return false;
    }

    void accept(FieldProblem& field, double tried, float length)
    {
        _phi.swap(_tried);
        _cost = tried;
        _last.swap(_gradient);
        gradient(field, _gradient);
        _descent.remember(_direction, length, _last, _gradient);
    }

    double _scale = 1.0; // s: Pa at a_l = 1
    double _cost = 0.0;
    Eigen::VectorXf _phi, _tried, _gradient, _last, _direction; // m
    QuasiNewton _descent{kMemory};
};

} // namespace

std::unique_ptr<HologramSolver> makeLbfgs(const SolverOptions& options)
{
    return std::make_unique<Lbfgs>(options);
}

} // namespace midair::haptics
