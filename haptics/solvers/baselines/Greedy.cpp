#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/kernels/PhaseKernels.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace midair::haptics
{

namespace
{

// Requested loudness E. It is below the 0.9 to 1.3 that unit amplitudes reach, so that every point
// can reach its target, and close to how the reference implementation is used; 0.7 halves the
// error, 0.9 doubles it.
constexpr double kAim = 0.8;
constexpr int kContinuousLevels = 256; // levels tried for a device with continuous phases
constexpr int kClockInterval = 6400;   // points times transducers between deadline checks

/// Sets one transducer after the other to the phase level that leaves the least error (Suzuki,
/// Fujiwara, Makino, Shinoda, "Radiation pressure field reconstruction for ultrasound midair
/// haptics by greedy algorithm with brute-force search", IEEE Transactions on Haptics 14, 2021):
/// min over phi of sum_l | s a_l - |p_l + G_li exp(j phi)| |, where p is the field of the
/// transducers set so far. Uses the device's phase levels. An iteration is a pass over all
/// transducers in shuffled order; further passes remove each transducer and choose its phase again.
class Greedy final : public SolverBase
{
public:
    explicit Greedy(const SolverOptions& options) : SolverBase("greedy", options) {}

private:
    Outcome iterate(FieldProblem& field, bool /*warm*/) override
    {
        prepare(field);
        Outcome outcome;
        const int limit = iterationLimit(1);
        std::mt19937_64 random(options().seed);
        while (outcome.iterations < limit && outcome.stop == StopReason::MAX_ITERATIONS)
        {
            shuffle(random);
            if (!pass(field, outcome.iterations > 0)) outcome.stop = StopReason::DEADLINE;
            ++outcome.iterations;
            if (outcome.stop == StopReason::MAX_ITERATIONS &&
                rms(field.n()) <= options().rmsTolerance)
                outcome.stop = StopReason::CONVERGED;
        }
        return outcome;
    }

    void prepare(FieldProblem& field)
    {
        const auto n = static_cast<std::size_t>(field.n()), m = static_cast<std::size_t>(field.m());
        _levels = field.drive().phaseLevels > 0 ? std::min(field.drive().phaseLevels, 4096)
                                                : kContinuousLevels;
        const auto levels = static_cast<std::size_t>(_levels);
        _turns.reserve(levels);
        for (std::size_t k = 0; k < levels; ++k)
            _turns.set(
                k,
                std::polar(1.0f,
                           static_cast<float>(base::kTwoPi * static_cast<double>(k) / _levels)));
        const std::size_t stride =
            (n + kernels::kPhaseLanes - 1) / kernels::kPhaseLanes * kernels::kPhaseLanes;
        for (SplitVector* v : {&_p, &_column})
        {
            v->reserve(stride);
            v->re.setZero();
            v->im.setZero();
        }
        _wanted.reserve(stride);
        _wanted.setZero();
        const double scale = kAim * field.meanRowSum() / static_cast<double>(field.a.norm());
        for (std::size_t l = 0; l < n; ++l)
            _wanted[l] = static_cast<float>(scale) * field.a[static_cast<Eigen::Index>(l)];
        _order.resize(m);
        std::iota(_order.begin(), _order.end(), 0);

        // If time runs out, the remaining transducers play the phases that follow from the points'
        // starting phases.
        for (std::size_t l = 0; l < n; ++l)
            field.w.set(l, field.u.at(l) * field.a[static_cast<Eigen::Index>(l)]);
        field.backward(field.w, field.q);
    }

    // Makes a pass over all transducers; \a takeOut: removes each before it is set. Returns false
    // if time ran out.
    bool pass(FieldProblem& field, bool takeOut)
    {
        const auto n = static_cast<std::size_t>(field.n());
        const int interval = std::max(1, kClockInterval / field.n());
        int done = 0;
        for (const int i : _order)
        {
            const auto s = static_cast<std::size_t>(i);
            for (std::size_t l = 0; l < n; ++l)
            {
                const std::complex<float> g = field.G.at(static_cast<int>(l), i);
                _column.set(l, g);
                if (takeOut) _p.set(l, _p.at(l) - g * field.q.at(s));
            }
            const int best = kernels::bestTurn(field.n(),
                                               _levels,
                                               _turns.re.data(),
                                               _turns.im.data(),
                                               _column.re.data(),
                                               _column.im.data(),
                                               _p.re.data(),
                                               _p.im.data(),
                                               _wanted.data());
            const std::complex<float> q = _turns.at(static_cast<std::size_t>(best));
            field.q.set(s, q);
            for (std::size_t l = 0; l < n; ++l)
                _p.set(l, _p.at(l) + _column.at(l) * q);
            if (++done % interval == 0 && outOfTime(field)) return false;
        }
        return true;
    }

    double rms(int n)
    {
        _reached.resize(n);
        for (int l = 0; l < n; ++l)
            _reached[l] = std::abs(_p.at(static_cast<std::size_t>(l)));
        const Eigen::Map<const Eigen::VectorXf> wanted(_wanted.data(), n);
        return relativeErrors(_reached, wanted, fittedLevelInOrder(_reached, wanted)).rms;
    }

    // Replaces std::shuffle, which differs between libraries.
    void shuffle(std::mt19937_64& random)
    {
        for (std::size_t i = _order.size(); i > 1; --i)
            std::swap(_order[i - 1], _order[random() % i]);
    }

    int _levels = 0;
    SplitVector _turns;      // the levels' phase factors
    SplitVector _p, _column; // n, padded with zeros
    base::AlignedBuffer<float> _wanted;
    Eigen::VectorXf _reached; // n, |p|
    std::vector<int> _order;
};

} // namespace

std::unique_ptr<HologramSolver> makeGreedy(const SolverOptions& options)
{
    return std::make_unique<Greedy>(options);
}

} // namespace midair::haptics
