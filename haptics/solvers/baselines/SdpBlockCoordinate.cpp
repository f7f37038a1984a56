#include "haptics/solvers/LargeMatrix.h"
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

constexpr int kDefaultIterations = 1000;
constexpr double kBarrier = 0.1; // mu of the paper

/// Semidefinite relaxation of min u* M u over unit phases, U = u u* relaxed to diag(U) = 1, U >= 0,
/// by block coordinate descent with a barrier (the paper's Algorithm 2, after Waldspurger,
/// d'Aspremont, Mallat 2015): for an index i, the others ic,
///     x = U_icic M_ici,  gamma = x* M_ici,  U_ici = -sqrt((1 - mu)/gamma) x  (0 where gamma <= 0).
/// Each round visits all indices in shuffled order. u is the leading eigenvector of U with its
/// entries projected to modulus 1; without that, some of about eleven points or more are lost.
class SdpBlockCoordinate final : public SolverBase
{
public:
    explicit SdpBlockCoordinate(const SolverOptions& options) : SolverBase("sdp-bcd", options) {}

private:
    int mostPoints() const override { return base::kMostDensePoints; }

    Outcome iterate(FieldProblem& field, bool /*warm*/) override
    {
        const int n = field.n();
        const TikhonovInverse inverse(field, options().lambda);
        const Eigen::MatrixXcd M = inverse.objective(field.a);
        Eigen::MatrixXcd U = Eigen::MatrixXcd::Identity(n, n);
        std::vector<int> order(static_cast<std::size_t>(n));
        std::iota(order.begin(), order.end(), 0);
        std::mt19937_64 random(options().seed);

        Outcome outcome;
        const int limit = iterationLimit(kDefaultIterations);
        Eigen::VectorXcd column(n), x(n);
        while (outcome.iterations < limit && outcome.stop == StopReason::MAX_ITERATIONS)
        {
            if (outcome.iterations % n == 0) shuffle(order, random);
            const int i = order[static_cast<std::size_t>(outcome.iterations % n)];
            column = M.col(i);
            column[i] = 0.0;
            x.noalias() = U * column;
            x[i] = 0.0;
            const double gamma = column.dot(x).real();
            x *= gamma > 0.0 ? -std::sqrt((1.0 - kBarrier) / gamma) : 0.0;
            x[i] = 1.0;
            U.col(i) = x;
            U.row(i) = x.adjoint();
            ++outcome.iterations;
            if (outOfTime(field)) outcome.stop = StopReason::DEADLINE;
        }
        Eigen::VectorXcd u = leadingPair(U, 1e-10, field.stop()).vector;
        for (int l = 0; l < n; ++l)
            u[l] = std::abs(u[l]) > 1e-12 ? u[l] / std::abs(u[l]) : 1.0;
        inverse.play(field, u);
        return outcome;
    }

    // Replaces std::shuffle, which differs between libraries.
    static void shuffle(std::vector<int>& order, std::mt19937_64& random)
    {
        for (std::size_t i = order.size(); i > 1; --i)
            std::swap(order[i - 1], order[random() % i]);
    }
};

} // namespace

std::unique_ptr<HologramSolver> makeSdpBlockCoordinate(const SolverOptions& options)
{
    return std::make_unique<SdpBlockCoordinate>(options);
}

} // namespace midair::haptics
