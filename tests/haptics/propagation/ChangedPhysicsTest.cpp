// What a field becomes where the array and the air aren't as in the model; the benchmark of the
// model's uncertainty prints it.
#include "tests/haptics/propagation/ChangedPhysics.h"

#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// A field of 50 points and the array that it was solved for.
struct Solved
{
    TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(50, 0.03);
    Eigen::VectorXcf q;
    SolveReport report = makeSolver(solverNames().front())->solve(points, array, Medium(), q);

    ChangedField with(const ArraySpread& spread, std::uint64_t seed = 1) const
    {
        return changedField(points, spreadArray(array, spread, seed), Medium(), q);
    }
    /// Returns sqrt(mean_l(sum_i |G_li q_i|^2 / y_l^2)): relative rms that independent deviations
    /// of rms 1 along a pressure would leave.
    double share() const
    {
        const Eigen::MatrixXcd parts =
            referencePropagationMatrix(points.positions, array, Medium()) *
            q.cast<std::complex<double>>().asDiagonal();
        const Eigen::VectorXd y = parts.rowwise().sum().cwiseAbs();
        return std::sqrt((parts.cwiseAbs2().rowwise().sum().array() / y.array().square()).mean());
    }
};

} // namespace

TEST(ChangedPhysics, TheModelItselfGivesTheReportsFigures)
{
    const Solved solved;
    const ChangedField same = solved.with({});
    // The report's are of float pressures, 1e-5 of all transducers in phase; of 50 points one gets
    // a seventh of that.
    EXPECT_NEAR(same.rms, solved.report.rms, 7e-5);
    EXPECT_NEAR(same.level_Pa / solved.report.level_Pa, 1.0, 7e-5);
}

TEST(ChangedPhysics, AFactorOnAllTransducersChangesTheLevelOnly)
{
    const Solved solved;
    TransducerArray louder = solved.array;
    louder.gain = Eigen::VectorXd::Constant(louder.size(), 1.25);
    louder.phaseOffset_rad = Eigen::VectorXd::Constant(louder.size(), 0.7);
    const ChangedField same = solved.with({});
    const ChangedField field = changedField(solved.points, louder, Medium(), solved.q);
    EXPECT_NEAR(field.level_Pa / same.level_Pa, 1.25, 1e-12);
    EXPECT_NEAR(field.rms, same.rms, 1e-12);
}

TEST(ChangedPhysics, IndependentSpreadLeavesWhatAddingUpPredicts)
{
    // p_l = sum_i G_li q_i (1 + g_i) e^{j eps_i}: to first order its modulus is off by the sum of
    // |G_li q_i| (g_i cos - eps_i sin) of the angle to p_l. With these angles spread widely
    // cos^2 and sin^2 are about half on average, phases' a bit less and gains' a bit more: 20 %.
    const Solved solved;
    const double share = solved.share() / std::sqrt(2.0);
    double gain = 0.0;
    double phase = 0.0;
    double level = 0.0;
    constexpr int kDraws = 5;
    for (int draw = 1; draw <= kDraws; ++draw)
    {
        gain += solved.with({0.1, 0.0, 0.0}, static_cast<std::uint64_t>(draw)).rms / kDraws;
        const ChangedField field = solved.with({0.0, 20.0, 0.0}, static_cast<std::uint64_t>(draw));
        phase += field.rms / kDraws;
        level += field.level_Pa / solved.with({}).level_Pa / kDraws;
    }
    EXPECT_GT(gain, 0.8 * 0.1 * share);
    EXPECT_LT(gain, 1.4 * 0.1 * share);
    EXPECT_GT(phase, 0.6 * base::toRadians(20.0) * share);
    EXPECT_LT(phase, 1.2 * base::toRadians(20.0) * share);
    // E(e^{j eps}) = e^{-sigma^2/2} = 0.9409; 0.5 % is what the draws scatter by at most.
    EXPECT_NEAR(level, std::exp(-0.5 * std::pow(base::toRadians(20.0), 2)), 0.005);
}

TEST(ChangedPhysics, ShiftingTheWholeArrayIsNoSpread)
{
    // Positions off by the same step move the field, and points that move with it get what they
    // had.
    const Solved solved;
    const Eigen::Vector3d step(0.3e-3, -0.2e-3, 0.1e-3);
    TransducerArray shifted = solved.array;
    shifted.positions.colwise() += step;
    ControlPoints points = solved.points;
    points.positions.colwise() += step;
    EXPECT_NEAR(changedField(points, shifted, Medium(), solved.q).rms, solved.with({}).rms, 1e-9);
    // Independent steps of that size do harm: 2 pi 0.2 mm / 8.6 mm = 0.15 rad along the way.
    EXPECT_GT(solved.with({0.0, 0.0, 0.2e-3}).rms, 5.0 * solved.with({}).rms);
}

TEST(ChangedPhysics, ASeedIsADraw)
{
    const Solved solved;
    const ArraySpread spread{0.1, 10.0, 0.3e-3};
    EXPECT_EQ(solved.with(spread, 1).rms, solved.with(spread, 1).rms);
    EXPECT_NE(solved.with(spread, 1).rms, solved.with(spread, 2).rms);
}
