#include "haptics/solvers/HologramSolver.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// Errors and level of q recomputed in double, by the definitions of the report.
void expectReportIsTrue(const SolveReport& report,
                        const ControlPoints& points,
                        const TransducerArray& array,
                        const Eigen::VectorXcf& q)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, Medium{});
    const Eigen::VectorXd y = (G * q.cast<std::complex<double>>()).cwiseAbs();
    const double s = y.dot(points.targets) / points.targets.squaredNorm();
    const Eigen::ArrayXd error = y.array() / (s * points.targets.array()) - 1.0;
    // Float products of up to 4000 terms: 1e-5 of the pressures; the output has to agree to 1e-3.
    EXPECT_NEAR(report.rms, std::sqrt(error.square().mean()), 1e-4);
    EXPECT_NEAR(report.max, error.abs().maxCoeff(), 1e-4);
    EXPECT_NEAR(report.level_Pa, s * points.targets.maxCoeff(), 1e-4 * report.level_Pa);
    EXPECT_NEAR(
        report.loudness, s * points.targets.norm() / G.cwiseAbs().rowwise().sum().mean(), 1e-4);
}

void expectOnLevels(const TransducerArray& array, const Eigen::VectorXcf& q)
{
    const float step =
        2.0f * static_cast<float>(M_PI) / static_cast<float>(array.drive.phaseLevels);
    for (int i = 0; i < q.size(); ++i)
    {
        const float level = std::arg(q[i]) / step;
        ASSERT_LT(std::fabs(level - std::round(level)), 1e-3f) << i;
        float nearest = 1.0f;
        for (const float a : array.drive.amplitudeLevels)
            nearest = std::min(nearest, std::fabs(std::abs(q[i]) - a));
        ASSERT_LT(nearest, 1e-6f) << i;
    }
}

std::string
refusalOf(const ControlPoints& points, const TransducerArray& array, const Medium& medium = {})
{
    std::string message;
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
        const SolveReport report = makeSolver(name)->solve(points, array, medium, q);
        EXPECT_EQ(report.stop, StopReason::REFUSED) << name;
        EXPECT_EQ(q.size(), array.size());
        EXPECT_TRUE(q.isZero()) << name;
        message = report.message;
    }
    return message;
}

} // namespace

TEST(SolverOptions, NamesTheViolatedConstraint)
{
    const auto why = [](auto change)
    {
        SolverOptions options;
        change(options);
        std::string error;
        EXPECT_FALSE(options.isValid(&error));
        return error;
    };
    EXPECT_TRUE(SolverOptions{}.isValid());
    EXPECT_EQ(why([](SolverOptions& o) { o.maxIterations = -1; }),
              "solver option maxIterations is -1; it must be within 0 .. 1e+06");
    EXPECT_EQ(why([](SolverOptions& o) { o.rmsTolerance = NAN; }),
              "solver option rmsTolerance is nan; it must be within 0 .. 1");
    EXPECT_EQ(why([](SolverOptions& o) { o.deadline_ms = -2.0; }),
              "solver option deadline is -2 ms; it must be within 0 .. 1e+06");
    EXPECT_EQ(why([](SolverOptions& o) { o.lambda = INFINITY; }),
              "solver option lambda is inf; it must be finite and at least 0");
    EXPECT_EQ(why([](SolverOptions& o) { o.loudness = 2.5; }),
              "solver option loudness is 2.5; it must be within 1e-06 .. 2");
    EXPECT_EQ(why([](SolverOptions& o) { o.threads = 0; }),
              "solver option threads is 0; it must be within 1 .. 256");
    EXPECT_EQ(why([](SolverOptions& o) { o.updateRate_Hz = 0.0; }),
              "solver option updateRate_Hz is 0; it must be above 0");
}

TEST(MakeSolver, RefusesUnknownNamesAndInvalidOptions)
{
    try
    {
        makeSolver("magic");
        FAIL();
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_EQ(std::string(error.what()).find("unknown solver 'magic'; known are "), 0u);
        for (const std::string& name : solverNames())
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
    }
    SolverOptions options;
    options.threads = -3;
    EXPECT_THROW(makeSolver(solverNames().front(), options), midair::base::InputError);
}

TEST(EverySolver, PlaysOnTheDevicesLevelsAndReportsWhatThatMakes)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(16, 0.03);
    for (int l = 0; l < 16; l += 3)
        points.targets[l] = 0.5;
    for (const std::string& name : solverNames())
        for (const bool phaseOnly : {true, false})
        {
            SCOPED_TRACE(name + (phaseOnly ? " phases" : " phases and amplitudes"));
            SolverOptions options;
            options.phaseOnly = phaseOnly;
            Eigen::VectorXcf q;
            const SolveReport report = makeSolver(name, options)->solve(points, array, Medium{}, q);
            EXPECT_EQ(report.solver, name);
            EXPECT_EQ(report.points, 16);
            EXPECT_EQ(report.transducers, 3984);
            EXPECT_EQ(report.rowsBuilt, 16);
            ASSERT_EQ(q.size(), array.size());
            EXPECT_LT(report.rms, 0.5); // every method finds the points; how well is its own test
            EXPECT_GT(report.loudness, 0.5);
            expectOnLevels(array, q);
            expectReportIsTrue(report, points, array, q);
        }
}

// Where it says nothing, nobody uses it.
TEST(EverySolver, KnowsThePressuresOfItsFieldOrSaysNothing)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    for (const std::string& name : solverNames())
        for (const bool phaseOnly : {true, false})
        {
            SCOPED_TRACE(name);
            SolverOptions options;
            options.phaseOnly = phaseOnly;
            const auto solver = makeSolver(name, options);
            ControlPoints points = spherePoints(16, 0.03);
            Eigen::VectorXcf q;
            for (int update = 0; update < 4; ++update)
            {
                if (update == 3) points.targets[2] = 5e-3;
                points.positions.row(0).array() += 1e-3;
                const SolveReport report = solver->solve(points, array, Medium{}, q);
                const Eigen::VectorXf& known = solver->achieved_Pa();
                ASSERT_EQ(known.size(), 16);
                const Eigen::VectorXd y =
                    (referencePropagationMatrix(points.positions, array, Medium{}) *
                     q.cast<std::complex<double>>())
                        .cwiseAbs();
                for (int l = 0; l < 16; ++l)
                    EXPECT_NEAR(known[l], y[l], std::min(1e-4 * report.level_Pa, 5e-3 * y[l]));
            }
            points.positions(0, 3) += 1e-3; // one row is new
            solver->solve(points, array, Medium{}, q);
            EXPECT_EQ(solver->achieved_Pa().size(), 0);
            points.positions.row(0).array() += 1e-3;
            points.targets[2] = 0.0;
            solver->solve(points, array, Medium{}, q);
            EXPECT_EQ(solver->achieved_Pa().size(), 0);
            points.targets[2] = 1.0;
            points.positions.row(0).array() += 1e-3;
            solver->solve(points, array, Medium{}, q);
            EXPECT_EQ(solver->achieved_Pa().size(), 16);
            solver->solve(points, array, Medium{}, q); // skipped, or all rows kept
            EXPECT_EQ(solver->achieved_Pa().size(), 0);
        }
}

TEST(EverySolver, RefusesWhatCannotBeSolved)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points = spherePoints(3, 0.03, {0.0, 0.0, 0.2});
    ControlPoints bad = points;
    bad.positions(1, 2) = NAN;
    EXPECT_EQ(refusalOf(bad, array).find("control point 2 is at ("), 0u);
    for (const double target : {-1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    {
        bad = points;
        bad.targets[1] = target;
        const std::string message = refusalOf(bad, array);
        EXPECT_EQ(message.find("control point 1 has the target "), 0u) << message;
    }
    bad = points;
    bad.targets.resize(2);
    EXPECT_EQ(refusalOf(bad, array), "there are 3 control points and 2 targets");
    EXPECT_EQ(refusalOf(points, TransducerArray{}), "the array has no transducers");
    TransducerArray broken = array;
    broken.positions(0, 5) = NAN;
    EXPECT_EQ(refusalOf(points, broken), "the array has a position or normal that is not finite");
    Medium medium;
    medium.temperature_C = 300.0;
    EXPECT_NE(refusalOf(points, array, medium).find("300"), std::string::npos);
    TransducerArray mirrored = array;
    Reflector table;
    table.name = "table";
    table.position[2] = points.positions(2, 0) + 0.004;
    mirrored.reflectors = {table};
    EXPECT_EQ(refusalOf(points, mirrored),
              "reflector 'table': its accuracy is 0 mm; it must be within 1e-6 .. 1000");
    mirrored.reflectors.front().accuracy_mm = 0.2;
    const std::string near = refusalOf(points, mirrored);
    EXPECT_EQ(near.find("control point 0 is "), 0U) << near;
    EXPECT_NE(near.find(" mm from reflector 'table'"), std::string::npos) << near;
}

// The rows hold the waves of images, so that what is solved for is what a mirrored array plays.
TEST(EverySolver, FieldsBeforeAPlaneAreRightWithItsImages)
{
    TransducerArray array = TransducerArray::singleBoard();
    Reflector plane;
    plane.position = {0.0, 0.0, 0.3};
    plane.normal = Eigen::Vector3d(0.05, 0.1, -1.0).normalized();
    plane.along = plane.normal.unitOrthogonal();
    plane.accuracy_mm = 0.1;
    TransducerArray images = array;
    const Eigen::Matrix3d turn =
        Eigen::Matrix3d::Identity() - 2.0 * plane.normal * plane.normal.transpose();
    images.positions =
        (turn * (array.positions.colwise() - plane.position)).colwise() + plane.position;
    images.normals = turn * array.normals;
    array.reflectors = {plane};
    const ControlPoints points = spherePoints(8, 0.02, {0.0, 0.0, 0.15});
    TransducerArray free = array;
    free.reflectors.clear();
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, free, Medium()) +
                               referencePropagationMatrix(points.positions, images, Medium());
    const auto rmsOf = [&](const Eigen::VectorXcf& q)
    {
        const Eigen::VectorXd y = (G * q.cast<std::complex<double>>()).cwiseAbs();
        const double s = y.dot(points.targets) / points.targets.squaredNorm();
        return std::sqrt(((y.array() / (s * points.targets.array())) - 1.0).square().mean());
    };
    Eigen::VectorXcf q, without;
    const SolveReport report = makeSolver("gauss-newton")->solve(points, array, Medium(), q);
    makeSolver("gauss-newton")->solve(points, free, Medium(), without);
    EXPECT_NEAR(rmsOf(q), report.rms, 1e-4);
    EXPECT_LT(rmsOf(q), 1e-3);
    EXPECT_GT(rmsOf(without), 0.02);
}

TEST(EverySolver, HasNothingToDoWithoutPointsOrTargets)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints silent = spherePoints(3, 0.03, {0.0, 0.0, 0.2});
    silent.targets.setZero();
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
        SolveReport report = makeSolver(name)->solve(ControlPoints{}, array, Medium{}, q);
        EXPECT_EQ(report.stop, StopReason::NOTHING_TO_DO);
        EXPECT_EQ(report.message, "there are no control points");
        EXPECT_TRUE(q.isZero());
        report = makeSolver(name)->solve(silent, array, Medium{}, q);
        EXPECT_EQ(report.stop, StopReason::NOTHING_TO_DO);
        EXPECT_EQ(report.message, "every target is 0");
        EXPECT_TRUE(q.isZero());
    }
}

TEST(EverySolver, LeavesOutWhatNeedsNoFieldAndSaysSo)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(6, 0.03);
    points.targets[4] = 0.0;
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q;
        const SolveReport report = makeSolver(name)->solve(points, array, Medium{}, q);
        EXPECT_EQ(report.leftOut, 1);
        EXPECT_EQ(report.message,
                  "1 of 6 control points left out: target 0 or out of the array's reach");
        EXPECT_GT(report.loudness, 0.5);
    }
}

TEST(EverySolver, SkipsWhatDidNotMove)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points = spherePoints(5, 0.02, {0.0, 0.0, 0.15});
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        const auto solver = makeSolver(name);
        Eigen::VectorXcf q;
        const SolveReport first = solver->solve(points, array, Medium{}, q);
        const Eigen::VectorXcf before = q;
        ControlPoints moved = points;
        moved.positions.array() += 3e-8; // half of a hundred-thousandth of a wavelength
        SolveReport report = solver->solve(moved, array, Medium{}, q);
        EXPECT_EQ(report.stop, StopReason::SKIPPED);
        EXPECT_EQ(report.rowsBuilt, 0);
        EXPECT_EQ(report.rms, first.rms);
        EXPECT_EQ(q, before);
        moved.positions.col(3).array() += 1e-3;
        report = solver->solve(moved, array, Medium{}, q);
        EXPECT_NE(report.stop, StopReason::SKIPPED);
        EXPECT_EQ(report.rowsBuilt, 1);
        // The four rows that stayed are of points within 3e-8 m sqrt 3 of theirs: the field is the
        // same to that.
        expectOnLevels(array, q);
        moved.targets[0] = 0.5;
        EXPECT_NE(solver->solve(moved, array, Medium{}, q).stop, StopReason::SKIPPED);
    }
}

TEST(EverySolver, SaysHowMuchTheArrayCan)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(8, 0.03);
    points.targets.setConstant(1e6); // Pa: a hundred times what it has
    points.absolute = true;
    SolverOptions options;
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        Eigen::VectorXcf q;
        const SolveReport report = makeSolver(name, options)->solve(points, array, Medium{}, q);
        EXPECT_EQ(report.shortPoints, 8);
        EXPECT_GT(report.worstShortfall, 0.9);
        const char* const said = "8 of 8 control points fall short; the worst, point ";
        EXPECT_NE(report.message.find(said), std::string::npos) << report.message;
        EXPECT_NE(report.message.find(", asks for 1e+06 Pa and gets 1."), std::string::npos);

        points.targets.setConstant(0.5 * report.level_Pa);
        const SolveReport half = makeSolver(name, options)->solve(points, array, Medium{}, q);
        // Amplitude levels near one half are 0.5 % apart; the methods' own errors come on top.
        EXPECT_NEAR(half.level_Pa, points.targets[0], 0.02 * points.targets[0]);
        points.targets.setConstant(1e6);
    }
}

TEST(GaussNewton, MeetsAbsoluteTargetsHoweverFewThePoints)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    SolverOptions options;
    for (const bool phaseOnly : {true, false})
        for (const int n : {1, 2, 3, 4, 9})
        {
            SCOPED_TRACE(std::to_string(n) + (phaseOnly ? ", phases" : ", amplitudes too"));
            options.phaseOnly = phaseOnly;
            ControlPoints points = spherePoints(n, 0.02);
            points.targets.setConstant(500.0);
            points.absolute = true;
            Eigen::VectorXcf q;
            const SolveReport report =
                makeSolver("gauss-newton", options)->solve(points, array, Medium{}, q);
            EXPECT_NEAR(report.level_Pa, 500.0, 2.5);
            EXPECT_EQ(report.shortPoints, 0);
        }
}

TEST(EverySolver, IsRepeatable)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints points = spherePoints(12, 0.03);
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf first, second;
        makeSolver(name)->solve(points, array, Medium{}, first);
        makeSolver(name)->solve(points, array, Medium{}, second);
        EXPECT_EQ(first, second) << name;
    }
}

TEST(StopReason, HasNames)
{
    EXPECT_STREQ(stopReasonName(StopReason::CONVERGED), "converged");
    EXPECT_STREQ(stopReasonName(StopReason::SKIPPED), "skipped");
    EXPECT_STREQ(stopReasonName(StopReason::REFUSED), "refused");
}
