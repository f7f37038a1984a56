#include "haptics/sequence/FieldMonitor.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/propagation/ChangedPhysics.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <gtest/gtest.h>

using namespace midair::haptics;

// As the reference in double has it.
TEST(KelvinCost, IsWhatWarmerAirLeaves)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(40, 0.03);
    Medium medium;
    Eigen::VectorXcf q;
    makeSolver(solverNames().front())->solve(points, array, medium, q);
    const KelvinCost cost = kelvinCost(points, q, array, medium, 1);
    Medium warmer = medium;
    warmer.temperature_C += 1.0;
    const ChangedField there = changedField(points, array, warmer, q);
    EXPECT_NEAR(cost.rms, there.rms, 1e-5);
    EXPECT_GT(cost.rms, 1e-3);
    EXPECT_NEAR(cost.level, there.level_Pa / changedField(points, array, medium, q).level_Pa, 1e-5);
    // Targets in Pa know no other level: what is quieter is an error.
    points.absolute = true;
    points.targets *= 2.0 * there.level_Pa;
    EXPECT_NEAR(kelvinCost(points, q, array, medium, 1).rms, 0.5, 0.01);
}

TEST(KelvinCost, OfNothingIsNothing)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points = spherePoints(4, 0.01);
    points.positions.row(2).array() += 0.15;
    const Eigen::VectorXcf silence = Eigen::VectorXcf::Zero(array.size());
    EXPECT_EQ(kelvinCost(points, silence, array, Medium(), 1).level, 0.0);
    const Eigen::VectorXcf full = Eigen::VectorXcf::Ones(array.size());
    EXPECT_GT(kelvinCost(points, full, array, Medium(), 1).level, 0.0);
    points.targets.setZero();
    EXPECT_EQ(kelvinCost(points, full, array, Medium(), 1).level, 0.0);
    // At the end of the range it is a degree colder.
    points.targets.setOnes();
    Medium hot;
    hot.temperature_C = 60.0;
    EXPECT_GT(kelvinCost(points, full, array, hot, 1).level, 0.0);
}
