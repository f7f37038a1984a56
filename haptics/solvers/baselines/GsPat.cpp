#include "haptics/solvers/PhaseObjective.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr int kDefaultIterations = 20; // a fixed small number, as published
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
        const int limit = iterationLimit(kDefaultIterations);
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

std::unique_ptr<HologramSolver> makeGsPat(const SolverOptions& options)
{
    return std::make_unique<GsPat>(options);
}

} // namespace midair::haptics
