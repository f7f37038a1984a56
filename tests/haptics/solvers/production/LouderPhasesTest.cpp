#include "haptics/solvers/production/LouderPhases.h"

#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/ManyStarts.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

Eigen::VectorXcf found(LouderPhases& phases, const ControlPoints& points, const Eigen::VectorXcf& c)
{
    phases.begin(points, TransducerArray::octagonalPrism(), Medium(), c);
    while (phases.hasWork())
        phases.step();
    return phases.best();
}

/// The loudness of a drive and its rms error, in double precision.
std::pair<double, double> heard(const ControlPoints& points, const Eigen::VectorXcf& q)
{
    const Eigen::MatrixXcd G =
        referencePropagationMatrix(points.positions, TransducerArray::octagonalPrism(), Medium());
    const Eigen::VectorXd y = (G * q.cast<std::complex<double>>()).cwiseAbs();
    const double s = fittedLevel(y, points.targets);
    return {loudnessOf(s, points.targets.norm(), G.cwiseAbs().rowwise().sum().mean()),
            relativeRms(y, points.targets, s)};
}

} // namespace

TEST(LouderPhases, AreAsLoudAsTheBestOfManyLongStarts)
{
    const ControlPoints points = spherePoints(25, 0.03);
    const TransducerArray array = TransducerArray::octagonalPrism();
    GaussNewtonTuning tuning; // the slow reference
    tuning.coldStarts = 1;
    tuning.trialRounds = tuning.coldRounds = 300;
    ManyStarts many(
        [&](const SolverOptions& options) { return makeGaussNewton(options, tuning); }, {}, 10);
    Eigen::VectorXcf slow, q;
    many.solve(points, array, Medium(), slow);
    const auto solver = makeSolver("gauss-newton");
    solver->solve(points, array, Medium(), q);
    const double before = heard(points, q).first;
    LouderPhases phases{SolverOptions()};
    const Eigen::VectorXcf c = found(phases, points, solver->multipliers());
    ASSERT_TRUE(solver->startFrom(c));
    solver->solve(points, array, Medium(), q);
    const auto [loudness, rms] = heard(points, q);
    EXPECT_GT(loudness, 1.02 * before);
    EXPECT_GT(loudness, 0.998 * heard(points, slow).first);
    EXPECT_LT(rms, 1e-3);
    EXPECT_NEAR(loudness / before, phases.gain(), 0.005);
}

TEST(LouderPhases, EqualInputGivesEqualOutput)
{
    const ControlPoints points = spherePoints(12, 0.03);
    const auto solver = makeSolver("gauss-newton");
    Eigen::VectorXcf q;
    solver->solve(points, TransducerArray::octagonalPrism(), Medium(), q);
    LouderPhases a{SolverOptions()}, b{SolverOptions()};
    const Eigen::VectorXcf first = found(a, points, solver->multipliers());
    found(b, spherePoints(20, 0.04), Eigen::VectorXcf::Ones(20)); // is forgotten
    EXPECT_EQ(found(b, points, solver->multipliers()), first);
}

TEST(LouderPhases, KeepPointsThatWereLeftOutAndQuietOnes)
{
    ControlPoints points = spherePoints(12, 0.03);
    points.targets[3] = 0.0;
    points.targets[5] = 0.1;
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeSolver("gauss-newton");
    Eigen::VectorXcf q;
    const double before = solver->solve(points, array, Medium(), q).loudness;
    const Eigen::VectorXcf c = solver->multipliers();
    ASSERT_EQ(c.size(), 12);
    EXPECT_EQ(c[3], 0.0f);
    LouderPhases phases{SolverOptions()};
    const Eigen::VectorXcf best = found(phases, points, c);
    EXPECT_EQ(best[3], 0.0f);
    ASSERT_TRUE(solver->startFrom(best));
    const SolveReport report = solver->solve(points, array, Medium(), q);
    EXPECT_LT(report.rms, 2e-3);
    EXPECT_GT(report.loudness, 0.999 * before);
}

TEST(LouderPhases, HaveNothingToDoForOnePointOrNone)
{
    LouderPhases phases{SolverOptions()};
    phases.begin(spherePoints(1, 0.03),
                 TransducerArray::octagonalPrism(),
                 Medium(),
                 Eigen::VectorXcf::Ones(1));
    EXPECT_FALSE(phases.hasWork());
    phases.begin(spherePoints(3, 0.03), TransducerArray::octagonalPrism(), Medium(), {});
    EXPECT_FALSE(phases.hasWork());
    EXPECT_EQ(phases.gain(), 1.0);
}

TEST(LouderPhases, AStopEndsAStep)
{
    base::StopSource source;
    SolverOptions options;
    options.stop = source.token();
    LouderPhases phases(options);
    const ControlPoints points = spherePoints(12, 0.03);
    phases.begin(points, TransducerArray::octagonalPrism(), Medium(), Eigen::VectorXcf::Ones(12));
    source.request();
    EXPECT_THROW(phases.step(), base::Stopped);
    source.clear();
    while (phases.hasWork())
        phases.step();
    EXPECT_GT(phases.gain(), 1.0);
}

TEST(StartFrom, RefusesWhatIsNoStart)
{
    const auto solver = makeSolver("gauss-newton");
    EXPECT_EQ(solver->multipliers().size(), 0);
    EXPECT_FALSE(solver->startFrom(Eigen::VectorXcf::Ones(12)));
    Eigen::VectorXcf q;
    const TransducerArray array = TransducerArray::octagonalPrism();
    solver->solve(spherePoints(12, 0.03), array, Medium(), q);
    EXPECT_FALSE(solver->startFrom(Eigen::VectorXcf::Ones(11)));
    Eigen::VectorXcf c = solver->multipliers();
    EXPECT_TRUE(solver->startFrom(c));
    c[0] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(solver->startFrom(c));
    // Points that crowd are not solved for by multipliers.
    solver->solve(gridPoints(10, 1, 10, 2.9e-3), array, Medium(), q);
    EXPECT_EQ(solver->multipliers().size(), 0);
    EXPECT_EQ(makeSolver("gs")->multipliers().size(), 0);
}

TEST(PhaseWalk, KeepsItsBoundsAndComesNearer)
{
    const Eigen::VectorXcf from = Eigen::VectorXcf::Ones(3);
    Eigen::VectorXcf to(3);
    to << std::polar(2.0f, 0.3f), std::polar(2.0f, 0.5f), std::polar(2.0f, 0.1f);
    PhaseWalk walk(from, to);
    EXPECT_FALSE(walk.isOver());
    const float far = (walk.next() - from).norm();
    EXPECT_FALSE(walk.accept(2.0 * PhaseWalk::kMostTurn_rad, 1.0));
    EXPECT_LT((walk.next() - from).norm(), 0.6f * far);
    EXPECT_FALSE(walk.accept(0.0, 1.5));
    EXPECT_FALSE(walk.accept(std::numeric_limits<double>::quiet_NaN(), 1.0));
    int steps = 0;
    Eigen::VectorXcf here = from;
    for (; !walk.isOver() && steps < 1000; ++steps)
    {
        here = walk.next();
        EXPECT_TRUE(walk.accept(0.1 * PhaseWalk::kMostTurn_rad, 1.0));
    }
    EXPECT_GT(steps, 3);
    // A common phase and a common factor change no field.
    EXPECT_NEAR(std::abs(here.dot(to)), here.norm() * to.norm(), 1e-5f);
    EXPECT_NEAR(here.cwiseAbs().sum(), 3.0f, 1e-5f);
    PhaseWalk never(from, to);
    for (int k = 0; k < 1000 && !never.isOver(); ++k)
        EXPECT_FALSE(never.accept(1.0, 1.0));
    EXPECT_TRUE(never.isOver()) << "a field that can't be reached in small steps is given up";
}

TEST(CrowdedDescent, FindsALoudFieldForAPlaneAcrossTheAxis)
{
    const double spacing_m = Medium().wavelength(40e3) / 2.0;
    const ControlPoints points = gridPoints(14, 1, 14, spacing_m);
    Eigen::VectorXcf q;
    makeSolver("gauss-newton")->solve(points, TransducerArray::octagonalPrism(), Medium(), q);
    const auto [loudness, rms] = heard(points, q);
    EXPECT_GT(loudness, 1.0); // 0.46 from smooth phases
    EXPECT_LT(rms, 2e-3);
}

} // namespace midair::haptics
