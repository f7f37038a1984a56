#include "haptics/points/FittedLevel.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/WeightedRound.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace midair::haptics
{

namespace
{

constexpr int kDefaultIterations = 200;
// Least share of its target that a point counts as having when weights are updated.
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
        const int limit = iterationLimit(kDefaultIterations);
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

} // namespace

std::unique_ptr<HologramSolver> makeWeightedGerchbergSaxton(const SolverOptions& options)
{
    return std::make_unique<WeightedGerchbergSaxton>(options);
}

} // namespace midair::haptics
