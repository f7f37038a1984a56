// Tolerances so coarse that rows are quick and rounding is plain: the tolerance must be kept all
// the same, and the figures must be those of the field that plays.
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

constexpr double kTolerance = 5e-3;
constexpr double kTrue = 2e-3; ///< error of a figure that quick rows may have

SolverOptions coarse()
{
    SolverOptions options;
    options.rmsTolerance = kTolerance;
    options.skipTolerance = 0.0;
    return options;
}

/// Pressures of \a q, Pa, by the formula.
Eigen::VectorXd
pressuresOf(const ControlPoints& points, const TransducerArray& array, const Eigen::VectorXcf& q)
{
    return (referencePropagationMatrix(points.positions, array, Medium()) *
            q.cast<std::complex<double>>())
        .cwiseAbs();
}

/// \a count foci on circles of 20 mm, a turn of which takes 14 fields: 9 mm a field.
ControlPoints foci(int count, int field)
{
    ControlPoints points = gridPoints(std::min(count, 5), std::max(1, count / 5), 1, 0.045);
    for (Eigen::Index l = 0; l < points.positions.cols(); ++l)
    {
        const double angle = 2.0 * M_PI * field / 14.0 + 0.3 * static_cast<double>(l);
        points.positions.col(l) += 0.02 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    }
    return points;
}

} // namespace

TEST(CoarseTolerance, IsKeptByFociThatMoveAWavelengthAField)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    for (const int count : {1, 5, 10, 25})
    {
        SCOPED_TRACE(count);
        const auto solver = makeSolver(solverNames().front(), coarse());
        Eigen::VectorXcf q;
        for (int field = 0; field < 20; ++field)
        {
            const ControlPoints points = foci(count, field);
            const SolveReport report = solver->solve(points, array, Medium(), q);
            const Eigen::VectorXd y = pressuresOf(points, array, q);
            const double level = y.mean();
            const double rms = std::sqrt((y.array() / level - 1.0).square().mean());
            EXPECT_LE(rms, 1.2 * kTolerance) << field;
            EXPECT_NEAR(report.rms, rms, kTrue) << field;
            EXPECT_NEAR(report.level_Pa / level, 1.0, kTrue) << field;
            EXPECT_EQ(report.stop, StopReason::CONVERGED) << report.message;
        }
    }
}

TEST(CoarseTolerance, IsKeptByTargetsInPascal)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    for (const double target_Pa : {20.0, 300.0, 1000.0})
    {
        SCOPED_TRACE(target_Pa);
        const auto solver = makeSolver(solverNames().front(), coarse());
        Eigen::VectorXcf q;
        for (int field = 0; field < 20; ++field)
        {
            ControlPoints points = foci(10, field);
            points.absolute = true;
            points.targets *= target_Pa;
            points.targets[3] *= 0.6;
            solver->solve(points, array, Medium(), q);
            const Eigen::VectorXd y = pressuresOf(points, array, q);
            EXPECT_LE(std::sqrt((y.array() / points.targets.array() - 1.0).square().mean()),
                      1.5 * kTolerance)
                << field;
        }
    }
}

// A point that fades has less than three tenths of the others' target, and the finer way.
TEST(CoarseTolerance, LeavesFadingPointsToTheFinerWay)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeSolver(solverNames().front(), coarse());
    Eigen::VectorXcf q;
    for (int field = 0; field < 20; ++field)
    {
        ControlPoints points = foci(10, field);
        points.targets[0] = 0.05 * (field + 1);
        solver->solve(points, array, Medium(), q);
        const Eigen::VectorXd y = pressuresOf(points, array, q);
        const double level = y.tail(9).mean();
        EXPECT_NEAR(y[0] / level, points.targets[0], 0.02) << field;
    }
}

// The pressure cap would take them for exact.
TEST(CoarseTolerance, GivesNoKnownPressures)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    Eigen::VectorXcf q;
    const auto solver = makeSolver(solverNames().front(), coarse());
    solver->solve(foci(5, 0), array, Medium(), q);
    EXPECT_EQ(solver->achieved_Pa().size(), 0);
    const auto fine = makeSolver(solverNames().front());
    fine->solve(foci(5, 0), array, Medium(), q);
    EXPECT_EQ(fine->achieved_Pa().size(), 5);
}

// A board with few transducers and phases can't round plainly.
TEST(CoarseTolerance, StillShapesCoarseBoards)
{
    TransducerArray board = TransducerArray::singleBoard();
    board.drive.phaseLevels = 32;
    ControlPoints points = spherePoints(4, 0.015, Eigen::Vector3d(0.0, 0.0, 0.12));
    Eigen::VectorXcf q;
    const auto solver = makeSolver(solverNames().front(), coarse());
    const SolveReport report = solver->solve(points, board, Medium(), q);
    const auto fine = makeSolver(solverNames().front());
    EXPECT_LE(report.rms, 1.5 * fine->solve(points, board, Medium(), q).rms + 1e-3);
}
