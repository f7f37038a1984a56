// What a solver makes of input that is hard, crowded or absurd; each case's outcome is stated.
// MIDAIR_LONG_TESTS=1 adds 2000 points and 100,000 updates in a row.
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/LongTests.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment)
{
    ++allocations;
    void* memory =
        alignment > 16
            ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
            : std::malloc(size);
    if (!memory) throw std::bad_alloc();
    return memory;
}

} // namespace

// g++ takes the pairs below, once inlined, for mismatched ones.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

// Counted for the whole program; only differences are looked at.
void* operator new(std::size_t size)
{
    return counted(size, 0);
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
    return counted(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
    ++allocations;
    return std::malloc(size); // as delete frees it, whoever asks so: std::stable_sort does
}
void operator delete(void* memory) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept
{
    std::free(memory);
}

namespace
{

// Whatever comes out can be played and says what it is.
SolveReport sound(HologramSolver& solver,
                  const ControlPoints& points,
                  const TransducerArray& array,
                  Eigen::VectorXcf& q,
                  const Medium& medium = {})
{
    const SolveReport report = solver.solve(points, array, medium, q);
    EXPECT_EQ(q.size(), array.size());
    EXPECT_TRUE(q.allFinite());
    EXPECT_LE(q.size() == 0 ? 0.0f : q.cwiseAbs().maxCoeff(), 1.0f + 1e-6f);
    EXPECT_TRUE(std::isfinite(report.rms) && std::isfinite(report.max) &&
                std::isfinite(report.loudness) && std::isfinite(report.level_Pa));
    if (report.stop == StopReason::REFUSED || report.stop == StopReason::NOTHING_TO_DO)
    {
        EXPECT_TRUE(q.isZero());
        EXPECT_FALSE(report.message.empty());
    }
    else
    {
        EXPECT_GT(report.loudness, 0.0);
        EXPECT_GT(q.cwiseAbs().maxCoeff(), 0.0f);
    }
    return report;
}

SolveReport
sound(const ControlPoints& points, const TransducerArray& array, const Medium& medium = {})
{
    Eigen::VectorXcf q;
    return sound(*makeSolver("gauss-newton"), points, array, q, medium);
}

ControlPoints at(const Eigen::Matrix3Xd& positions)
{
    ControlPoints points;
    points.positions = positions;
    points.normals = Eigen::Vector3d::UnitY().replicate(1, positions.cols());
    points.targets = Eigen::VectorXd::Ones(positions.cols());
    return points;
}

Eigen::Matrix3Xd grid(int columns, int rows, double spacing_m)
{
    Eigen::Matrix3Xd positions(3, columns * rows);
    for (int l = 0; l < columns * rows; ++l)
        positions.col(l) =
            spacing_m *
            Eigen::Vector3d(l % columns - 0.5 * (columns - 1), 0.0, l / columns - 0.5 * (rows - 1));
    return positions;
}

// The rms error of one focus in the middle of \a points, all of which want one pressure.
double rmsOfFocus(const ControlPoints& points, const TransducerArray& array)
{
    const Eigen::Matrix3Xd middle = points.positions.rowwise().mean();
    Eigen::VectorXcd q = referencePropagationMatrix(middle, array, Medium{}).row(0).adjoint();
    q.array() /= q.array().abs();
    const Eigen::VectorXd y =
        (referencePropagationMatrix(points.positions, array, Medium{}) * q).cwiseAbs();
    return std::sqrt((y.array() / y.mean() - 1.0).square().mean());
}

} // namespace

TEST(SolverStress, FromOnePointToHundreds)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    for (const int n : {1, 2, 3, 7, 31, 150})
    {
        SCOPED_TRACE(n);
        // 8-bit phases leave 0.0014 at n = 150, the only one spaced under a wavelength.
        EXPECT_LT(sound(spherePoints(n, 0.045), array).rms, 0.003);
    }
    if (!longTestsAsked()) return;
    EXPECT_LT(sound(spherePoints(2000, 0.09), array).rms, 0.5);
}

TEST(SolverStress, CrowdedPointsGiveAFieldWithItsError)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    // Twice the same point: the same pressure is asked for twice, which costs nothing.
    ControlPoints twice = spherePoints(20, 0.03);
    twice.positions.rightCols(10) = twice.positions.leftCols(10);
    EXPECT_LT(sound(twice, array).rms, 0.003);
    // The same point asked for two pressures: none can be met better than half way.
    twice.targets.tail(10).setConstant(0.5);
    EXPECT_GT(sound(twice, array).rms, 0.2);
    EXPECT_LT(sound(at(grid(30, 1, 8.5e-3)), array).rms, 0.01); // collinear
    EXPECT_LT(sound(at(grid(7, 7, 8.5e-3)), array).rms, 0.02);  // coplanar
    // A tenth of a wavelength apart.
    for (int k = 0; k < 60; ++k)
        EXPECT_LT(sound(at(grid(20, 1, 0.75e-3 + 3.5e-6 * k)), array).rms, 0.01) << k;
    // 36 points within half a wavelength: at least as even as one focus in their middle.
    const ControlPoints crowd = at(grid(6, 6, 0.85e-3));
    EXPECT_LT(sound(crowd, array).rms, rmsOfFocus(crowd, array));
}

TEST(SolverStress, PointsInPlacesNobodyCanReachWell)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(10, 0.03);
    points.positions.col(3) = array.positions.col(100); // on a transducer: taken as 5 mm before it
    sound(points, array);
    points.positions.col(3) = array.positions.col(100) - 0.03 * array.normals.col(100); // behind it
    sound(points, array);
    points.positions.col(3) = Eigen::Vector3d(10.0, 0.0, 0.0);
    sound(points, array);
    TransducerArray board = TransducerArray::singleBoard();
    board.directivity = Directivity::T4010A1_TABLE; // silent behind: such points are left out
    ControlPoints behind = spherePoints(4, 0.02, {0.0, 0.0, 0.2});
    behind.positions(2, 1) = -0.2;
    const SolveReport report = sound(behind, board);
    EXPECT_EQ(report.leftOut, 1);
    behind.positions.row(2).setConstant(-0.2);
    EXPECT_EQ(sound(behind, board).stop, StopReason::NOTHING_TO_DO);
}

TEST(SolverStress, TargetsOfManyOrdersOfMagnitude)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(20, 0.03);
    for (int l = 0; l < 20; ++l)
        points.targets[l] = 0.3 + 0.7 * (l * 7 % 20) / 19.0;
    EXPECT_LT(sound(points, array).rms, 0.005);
    points.targets.setOnes();
    points.targets[0] =
        1e6; // the others are to be a millionth of it: far below what 8 bits resolve
    sound(points, array);
    points.targets.setConstant(1e12);
    EXPECT_LT(sound(points, array).rms, 0.002);
    points.targets.setConstant(1e-12);
    EXPECT_LT(sound(points, array).rms, 0.002);
}

TEST(SolverStress, NothingToDoAndWhatCannotBe)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    EXPECT_EQ(sound(spherePoints(0, 0.03), array).stop, StopReason::NOTHING_TO_DO);
    ControlPoints points = spherePoints(12, 0.03);
    points.targets[4] = 0.0;
    EXPECT_EQ(sound(points, array).leftOut, 1);
    points.targets.setZero();
    EXPECT_EQ(sound(points, array).stop, StopReason::NOTHING_TO_DO);
    for (const double target : {-1.0, std::nan(""), static_cast<double>(INFINITY)})
    {
        points.targets.setOnes();
        points.targets[7] = target;
        const SolveReport report = sound(points, array);
        EXPECT_EQ(report.stop, StopReason::REFUSED) << target;
        EXPECT_NE(report.message.find("control point 7"), std::string::npos) << report.message;
    }
    points.targets.setOnes();
    points.positions(1, 3) = std::nan("");
    EXPECT_EQ(sound(points, array).stop, StopReason::REFUSED);
}

TEST(SolverStress, EverySeedIsAsGood)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    for (const std::uint64_t seed : {0ULL, 1ULL, 2ULL, 77ULL, ~0ULL})
    {
        SolverOptions options;
        options.seed = seed;
        Eigen::VectorXcf q;
        const SolveReport report =
            sound(*makeSolver("gauss-newton", options), spherePoints(50, 0.03), array, q);
        EXPECT_LT(report.rms, 0.0012) << seed;
        EXPECT_GT(report.loudness, 1.03) << seed;
    }
}

TEST(SolverStress, OddArraysAndAir)
{
    TransducerArray one = TransducerArray::singleBoard();
    one.positions = one.positions.leftCols(1).eval();
    one.normals = one.normals.leftCols(1).eval();
    one.board.resize(1);
    sound(spherePoints(1, 0.01, {0.0, 0.0, 0.2}), one);
    sound(spherePoints(5, 0.01, {0.0, 0.0, 0.2}), one); // more points than transducers
    TransducerArray coincident = TransducerArray::singleBoard();
    coincident.positions.colwise() = Eigen::Vector3d(0.0, 0.0, 0.0);
    coincident.normals.colwise() = Eigen::Vector3d(0.0, 0.0, 1.0);
    sound(spherePoints(5, 0.01, {0.0, 0.0, 0.2}), coincident);
    for (const double temperature_C : {-40.0, 60.0})
    {
        Medium medium;
        medium.temperature_C = temperature_C;
        EXPECT_LT(sound(spherePoints(20, 0.03), TransducerArray::octagonalPrism(), medium).rms,
                  0.002);
    }
}

TEST(SolverStress, EveryRegularisationGivesAField)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points = spherePoints(8, 0.02, {0.0, 0.0, 0.15});
    points.positions.col(7) = points.positions.col(6); // singular for lambda 0
    for (const std::string& name : solverNames())
        for (const double lambdaRel : {0.0, 1e-9, 0.1, 1e6})
        {
            SCOPED_TRACE(name + " lambdaRel " + std::to_string(lambdaRel));
            SolverOptions options;
            options.lambda = lambdaRel;
            options.maxIterations = 20;
            Eigen::VectorXcf q;
            sound(*makeSolver(name, options), points, array, q);
        }
}

TEST(SolverStress, NoDriftOverManyUpdates)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints base = spherePoints(25, 0.03);
    ControlPoints points = base;
    const auto solver = makeSolver("gauss-newton");
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    Eigen::VectorXcf q;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    const int updates = longTestsAsked() ? 100000 : 300;
    double worst = 0.0, least = 10.0;
    for (int k = 0; k < updates; ++k)
    {
        position = 0.98 * position +
                   5e-4 * Eigen::Vector3d(normal(random), normal(random), normal(random));
        const Eigen::Vector3d axis(normal(random), normal(random), normal(random));
        rotation = (Eigen::AngleAxisd(0.01 * axis.norm(), axis.normalized()) * rotation).eval();
        points.positions = (rotation * base.positions).colwise() + position;
        const SolveReport report = sound(*solver, points, array, q);
        worst = std::max(worst, report.rms);
        least = std::min(least, report.loudness);
    }
    // 8-bit phases leave 0.0006 at n = 25, and 0.001 is what is asked for.
    EXPECT_LT(worst, 2e-3);
    EXPECT_GT(least, 0.9);
}

TEST(SolverStress, AnUpdateAllocatesNothing)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(50, 0.03);
    for (const int threads : {1, 2})
    {
        SolverOptions options;
        options.threads = threads;
        const auto solver = makeSolver("gauss-newton", options);
        Eigen::VectorXcf q;
        for (int k = 0; k < 6; ++k)
        {
            points.positions.array() += 5e-4;
            const long before = allocations;
            solver->solve(points, array, Medium{}, q);
            if (k < 2) continue; // the buffers of warm updates
            EXPECT_EQ(allocations - before, 0) << "update " << k << " on " << threads << " threads";
        }
    }
}

TEST(SolverStress, TurningSceneAndArrayTogetherChangesNothing)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints points = spherePoints(20, 0.03);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    const Eigen::Vector3d shift(0.3, -0.2, 0.1);
    TransducerArray turnedArray = array;
    turnedArray.positions = (turn * array.positions).colwise() + shift;
    turnedArray.normals = turn * array.normals;
    ControlPoints turned = points;
    turned.positions = (turn * points.positions).colwise() + shift;
    const SolveReport first = sound(points, array), second = sound(turned, turnedArray);
    // G agrees to 1e-6; the rounds amplify that, and rounding to levels is a matter of luck at its
    // edges.
    EXPECT_NEAR(first.loudness, second.loudness, 0.01);
    EXPECT_NEAR(first.level_Pa, second.level_Pa, 0.01 * first.level_Pa);
}

TEST(SolverStress, ScalingAllTargetsChangesNothing)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(20, 0.03);
    points.targets[5] = 0.5;
    Eigen::VectorXcf first, second;
    sound(*makeSolver("gauss-newton"), points, array, first);
    points.targets *= 1024.0; // a power of two: exact in float
    sound(*makeSolver("gauss-newton"), points, array, second);
    EXPECT_EQ(first, second);
}

TEST(SolverStress, PermutingPointsChangesNothing)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints points = spherePoints(20, 0.03);
    ControlPoints reversed = points;
    reversed.positions = points.positions.rowwise().reverse();
    SolverOptions options;
    options.maxIterations =
        12; // one start, from equal phases: random ones belong to places in the list
    Eigen::VectorXcf first, second;
    sound(*makeSolver("gauss-newton", options), points, array, first);
    sound(*makeSolver("gauss-newton", options), reversed, array, second);
    // But for the order of sums and the levels that turn on it.
    EXPECT_GT(std::abs(first.dot(second)) / (first.norm() * second.norm()), 0.999f);
}

TEST(SolverStress, ThreadsShareTheWorkAndTheResultStaysRepeatable)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints points = spherePoints(40, 0.03);
    SolverOptions options;
    options.threads = 3; // 32 blocks of transducers: not evenly shared
    Eigen::VectorXcf one, three, again;
    const SolveReport alone = sound(*makeSolver("gauss-newton"), points, array, one);
    const SolveReport shared = sound(*makeSolver("gauss-newton", options), points, array, three);
    sound(*makeSolver("gauss-newton", options), points, array, again);
    EXPECT_EQ(three, again);
    // Sums in another order: 1e-6, amplified by the rounds.
    EXPECT_NEAR(alone.loudness, shared.loudness, 0.01);
    EXPECT_LT(shared.rms, 1.5e-3);
}
