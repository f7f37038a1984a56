#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/TikhonovInverse.h"

#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr int kDefaultIterations = 1000;
// The method has stalled once no point's phase changes by more than this in a round.
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
        const int limit = iterationLimit(kDefaultIterations);
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

} // namespace

std::unique_ptr<HologramSolver> makeGerchbergSaxton(const SolverOptions& options)
{
    return std::make_unique<GerchbergSaxton>(options);
}

} // namespace midair::haptics
