#include "haptics/points/FittedLevel.h"
#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/LargeMatrix.h"
#include "haptics/solvers/PhaseObjective.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace midair::haptics
{

namespace
{

constexpr int kGsIterations = 1000;
// The method has stalled if no point's phase changes by more than this in a round.
constexpr double kStill_rad = 1e-7;

/// Gerchberg-Saxton between the control points and the transducers (the paper's Algorithm 1): p <-
/// a phase(G G^- p).
class GerchbergSaxton final : public SolverBase
{
public:
    explicit GerchbergSaxton(const SolverOptions& options) : SolverBase("gs", options) {}

private:
    int mostPoints() const override { return base::kMostDensePoints; }

    Outcome iterate(FieldProblem& field, bool /*warm*/) override
    {
        const TikhonovInverse inverse(field, options().lambda);
        const Eigen::MatrixXcd T = inverse.projector(); // n x n: G G^-
        const Eigen::VectorXcd a = field.a.cast<std::complex<double>>();
        Eigen::VectorXcd u(field.n());
        for (int l = 0; l < field.n(); ++l)
            u[l] = std::complex<double>(field.u.at(static_cast<std::size_t>(l)));

        Outcome outcome;
        const int limit = iterationLimit(kGsIterations);
        while (outcome.iterations < limit && outcome.stop == StopReason::MAX_ITERATIONS)
        {
            const Eigen::VectorXcd p = T * a.cwiseProduct(u);
            double turned = 0.0;
            for (int l = 0; l < field.n(); ++l)
            {
                const double size = std::abs(p[l]);
                if (!(size > 0.0)) continue;
                const std::complex<double> next = p[l] / size;
                turned = std::max(turned, std::abs(next - u[l]));
                u[l] = next;
            }
            ++outcome.iterations;
            if (turned < kStill_rad) outcome.stop = StopReason::STALLED;
            if (outOfTime(field)) outcome.stop = StopReason::DEADLINE;
        }
        inverse.play(field, u);
        return outcome;
    }
};

constexpr int kWgsIterations = 200;
// Smallest assumed share of its target that a point has when weights are updated.
constexpr float kFewest = 1e-3f;
constexpr float kLeastWeight = 1e-6f; // least weight, where their mean is 1

/// Gerchberg-Saxton between points and unit-amplitude transducers with a weight per point (Marzo,
/// Drinkwater, "Holographic acoustic tweezers", PNAS 116, 2019; there after Di Leonardo, Ianni,
/// Ruocco 2007). A round:
///     q = unit(G* (w a u)),  p = G q,  u = p / |p|,  w_l <- w_l s a_l / |p_l|
/// with s so that the weights keep their mean.
class WeightedGerchbergSaxton final : public SolverBase
{
public:
    explicit WeightedGerchbergSaxton(const SolverOptions& options) : SolverBase("wgs", options) {}

private:
    Outcome iterate(FieldProblem& field, bool warm) override
    {
        const int n = field.n();
        // The weights belong to the last field, so they are kept with it.
        if (!warm || _weights.size() != n) _weights = Eigen::VectorXf::Ones(n);

        Outcome outcome;
        const int limit = iterationLimit(kWgsIterations);
        while (outcome.iterations < limit && outcome.stop == StopReason::MAX_ITERATIONS)
        {
            projectionRound(field, _weights.cwiseProduct(field.a));
            ++outcome.iterations;
            const float rms = reweigh(field);
            if (rms <= static_cast<float>(options().rmsTolerance))
                outcome.stop = StopReason::CONVERGED;
            else if (outOfTime(field))
                outcome.stop = StopReason::DEADLINE;
        }
        return outcome;
    }

    // Updates the weights by the rule above. Returns the rms of y_l / (s a_l) - 1.
    float reweigh(const FieldProblem& field)
    {
        const float s = fittedLevel(field.y, field.a);
        if (!(s > 0.0f)) return std::numeric_limits<float>::infinity();
        float squares = 0.0f;
        for (int l = 0; l < field.n(); ++l)
        {
            const float reached = field.y[l] / (s * field.a[l]);
            squares += (reached - 1.0f) * (reached - 1.0f);
            _weights[l] /= std::max(reached, kFewest);
        }
        _weights = (_weights / _weights.mean()).cwiseMax(kLeastWeight);
        return std::sqrt(squares / static_cast<float>(field.n()));
    }

    Eigen::VectorXf _weights;
};

constexpr int kGsPatIterations = 20; // a fixed small number, as published
constexpr float kStill = 1e-6f;

/// Phase retrieval in the space of the points (Plasencia, Hirayama, Montano-Murillo, Subramanian,
/// "GS-PAT", ACM Transactions on Graphics 39, 2020): with the back-propagation B = G* diag(1 /
/// sum_i |G_li|^2) and R = G B (n x n),
///     p = R (a u),  u = p / |p|;  finally, with corrected amplitudes,  q = B (a^2 / |p| u).
/// Without an inverse and weights it is fast, but the pressures are unequal. (In measurements the
/// authors' OpenCL implementation behaves as if without the correction, twice as unequal.)
class GsPat final : public SolverBase
{
public:
    explicit GsPat(const SolverOptions& options) : SolverBase("gs-pat", options) {}

private:
    int mostPoints() const override { return base::kMostDensePoints; }

    Outcome iterate(FieldProblem& field, bool /*warm*/) override
    {
        const Eigen::MatrixXcd K = gramMatrix(field.G, field.stop());
        const Eigen::VectorXd energy = K.diagonal().real(); // sum_i |G_li|^2
        const Eigen::MatrixXcf R =
            (K * energy.cwiseInverse().asDiagonal()).cast<std::complex<float>>();
        Eigen::VectorXcf u(field.n());
        for (int l = 0; l < field.n(); ++l)
            u[l] = field.u.at(static_cast<std::size_t>(l));

        Outcome outcome;
        Eigen::VectorXcf p = R * field.a.cwiseProduct(u);
        const int limit = iterationLimit(kGsPatIterations);
        while (outcome.iterations < limit && outcome.stop == StopReason::MAX_ITERATIONS)
        {
            float turned = 0.0f;
            for (int l = 0; l < field.n(); ++l)
            {
                const float size = std::abs(p[l]);
                if (!(size > 0.0f)) continue;
                turned = std::max(turned, std::abs(p[l] / size - u[l]));
                u[l] = p[l] / size;
            }
            p.noalias() = R * field.a.cwiseProduct(u);
            ++outcome.iterations;
            if (turned < kStill) outcome.stop = StopReason::STALLED;
            if (outOfTime(field)) outcome.stop = StopReason::DEADLINE;
        }
        for (int l = 0; l < field.n(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            const float size = std::abs(p[l]);
            const std::complex<float> phase = size > 0.0f ? p[l] / size : u[l];
            field.u.set(row, phase);
            // Energies are relative to the largest, so that nothing overflows whatever the unit of
            // pressure.
            const double share = energy.maxCoeff() / energy[l];
            const float correction = size > 0.0f ? field.a[l] / size : 1.0f;
            field.w.set(row, phase * (field.a[l] * correction * static_cast<float>(share)));
        }
        field.backward(field.w, field.q);
        return outcome;
    }
};

} // namespace

std::unique_ptr<HologramSolver> makeGerchbergSaxton(const SolverOptions& options)
{
    return std::make_unique<GerchbergSaxton>(options);
}

std::unique_ptr<HologramSolver> makeWeightedGerchbergSaxton(const SolverOptions& options)
{
    return std::make_unique<WeightedGerchbergSaxton>(options);
}

std::unique_ptr<HologramSolver> makeGsPat(const SolverOptions& options)
{
    return std::make_unique<GsPat>(options);
}

} // namespace midair::haptics
