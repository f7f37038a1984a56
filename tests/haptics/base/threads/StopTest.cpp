// Work is broken off where that is asked for, and refused where it would take gigabytes or minutes.
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "haptics/solvers/dense/OutlineHologram.h"
#include "tests/Eventually.h"
#include "tests/haptics/solvers/ScenePoints.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <chrono>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

using namespace midair::haptics;
using StdClock = std::chrono::steady_clock;

namespace
{

// What takes minutes or hours when it isn't broken off; milliseconds when it is, on a machine with
// a core to spare.
constexpr double kSoon_s = 20.0;

double since_s(StdClock::time_point start)
{
    return std::chrono::duration<double>(StdClock::now() - start).count();
}

/// Asks for a stop from another thread, a moment after it is made.
class Later
{
public:
    explicit Later(midair::base::StopSource& source) :
        _thread(
            [&source]
            {
                letPass(0.05);
                source.request();
            })
    {
    }
    ~Later() { _thread.join(); }

private:
    std::thread _thread;
};

class Solvers : public testing::TestWithParam<std::string>
{
};

std::string plainName(const testing::TestParamInfo<std::string>& info)
{
    std::string name = info.param;
    for (char& c : name)
        if (c == '-') c = '_';
    return name;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(All, Solvers, testing::ValuesIn(solverNames()), plainName);

TEST_P(Solvers, IsBrokenOffAndIsSilent)
{
    midair::base::StopSource source;
    SolverOptions options;
    options.maxIterations = 1000000;
    options.rmsTolerance = 0.0;
    options.skipTolerance = 0.0;
    options.stop = source.token();
    const auto solver = makeSolver(GetParam(), options);
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points = spherePoints(300, 0.03, {0.0, 0.0, 0.15});
    Eigen::VectorXcf q;
    SolveReport report;
    const StdClock::time_point start = StdClock::now();
    {
        const Later later(source);
        // Those that have nothing left to gain end by themselves, over and over, until the request
        // comes.
        while (report.stop != StopReason::STOPPED)
        {
            points.positions.col(0).x() += 1e-5;
            report = solver->solve(points, array, Medium(), q);
        }
    }
    EXPECT_LT(since_s(start), kSoon_s);
    EXPECT_EQ(report.message, "stopped before it was done");
    EXPECT_EQ(report.points, 300);
    ASSERT_EQ(q.size(), array.size());
    EXPECT_TRUE(q.isZero(0.0f));
}

TEST_P(Solvers, DoesNotBeginWhenItIsToStop)
{
    midair::base::StopSource source;
    source.request();
    SolverOptions options;
    options.stop = source.token();
    Eigen::VectorXcf q;
    const SolveReport report = makeSolver(GetParam(), options)
                                   ->solve(spherePoints(50, 0.03, {0.0, 0.0, 0.15}),
                                           TransducerArray::singleBoard(),
                                           Medium(),
                                           q);
    EXPECT_EQ(report.stop, StopReason::STOPPED);
    EXPECT_EQ(report.rowsBuilt, 0);
    EXPECT_STREQ(stopReasonName(report.stop), "stopped");
}

TEST_P(Solvers, SolvesAsIfNewAfterItWasStopped)
{
    midair::base::StopSource source;
    SolverOptions options;
    options.maxIterations = 20;
    const TransducerArray array = TransducerArray::singleBoard();
    const ControlPoints points = spherePoints(40, 0.03, {0.0, 0.0, 0.15});
    Eigen::VectorXcf expected, q;
    makeSolver(GetParam(), options)->solve(points, array, Medium(), expected);
    options.stop = source.token();
    const auto solver = makeSolver(GetParam(), options);
    solver->solve(points, array, Medium(), q);
    source.request();
    ControlPoints moved = points;
    moved.positions.row(0).array() += 0.002;
    EXPECT_EQ(solver->solve(moved, array, Medium(), q).stop, StopReason::STOPPED);
    source.clear();
    const SolveReport again = solver->solve(points, array, Medium(), q);
    EXPECT_EQ(again.rowsBuilt, 40);
    // Played fields of two solves differ by a common phase at most.
    EXPECT_NEAR(std::abs(q.dot(expected)), expected.squaredNorm(), 0.02 * expected.squaredNorm());
}

TEST_P(Solvers, MoreThanAFieldTakesIsRefusedByName)
{
    const int most = GetParam() == "gs" || GetParam() == "sdp-bcd" || GetParam() == "gs-pat"
                         ? midair::base::kMostDensePoints
                         : midair::base::kMostControlPoints;
    Eigen::VectorXcf q;
    const SolveReport report = makeSolver(GetParam())
                                   ->solve(spherePoints(most + 1, 0.05, {0.0, 0.0, 0.15}),
                                           TransducerArray::singleBoard(),
                                           Medium(),
                                           q);
    EXPECT_EQ(report.stop, StopReason::REFUSED);
    EXPECT_EQ(report.message,
              "there are " + std::to_string(most + 1) + " control points; " + GetParam() +
                  " is for at most " + std::to_string(most));
    EXPECT_TRUE(q.isZero(0.0f));
}

TEST(Stop, LouderRoundsAndSharedThreadsAreBrokenOffToo)
{
    midair::base::StopSource source;
    SolverOptions options;
    options.maxIterations = 1000000;
    options.rmsTolerance = 0.0;
    options.loudness = 1.5;
    options.stop = source.token();
    options.pool = std::make_shared<midair::base::ThreadPool>(2);
    Eigen::VectorXcf q;
    const Later later(source);
    const StdClock::time_point start = StdClock::now();
    const SolveReport report = makeSolver("wgs", options)
                                   ->solve(spherePoints(200, 0.03, {0.0, 0.0, 0.15}),
                                           TransducerArray::singleBoard(),
                                           Medium(),
                                           q);
    EXPECT_EQ(report.stop, StopReason::STOPPED);
    EXPECT_LT(since_s(start), kSoon_s);
}

TEST(Stop, FieldsInTurnAreAllSilentWhenOneIsStopped)
{
    midair::base::StopSource source;
    TimeMultiplexer matched(
        [&source]
        {
            SolverOptions options;
            options.stop = source.token();
            return makeSolver("gauss-newton", options);
        });
    const std::vector<ControlPoints> parts = {spherePoints(5, 0.02, {0.0, 0.0, 0.15}),
                                              spherePoints(6, 0.02, {0.0, 0.0, 0.16})};
    std::vector<Eigen::VectorXcf> fields;
    const TransducerArray array = TransducerArray::singleBoard();
    EXPECT_NE(matched.solve(parts, array, Medium(), fields).stop, StopReason::STOPPED);
    source.request();
    EXPECT_EQ(matched.solve(parts, array, Medium(), fields).stop, StopReason::STOPPED);
    for (const Eigen::VectorXcf& field : fields)
        EXPECT_TRUE(field.isZero(0.0f));
}

TEST(Stop, FieldsInTurnOfTooManyPointsAreRefused)
{
    TimeMultiplexer matched([] { return makeSolver("wgs"); });
    const std::vector<ControlPoints> parts(6, spherePoints(4000, 0.05));
    std::vector<Eigen::VectorXcf> fields;
    try
    {
        matched.solve(parts, TransducerArray::singleBoard(), Medium(), fields);
        ADD_FAILURE() << "no error";
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_STREQ(error.what(),
                     "fields in turn: the 6 fields have 24000 control points together; there must "
                     "be at most 20000");
    }
}

TEST(Stop, WhatHasNoReportThrows)
{
    midair::base::StopSource source;
    source.request();
    const TransducerArray array = TransducerArray::singleBoard();
    const ControlPoints points = spherePoints(30, 0.03, {0.0, 0.0, 0.15});
    const Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
    EXPECT_THROW(pressureAt(points.positions, array, Medium(), q, 1, source.token()),
                 midair::base::Stopped);

    SurfaceStatisticsOptions statistics;
    statistics.stop = source.token();
    EXPECT_THROW(surfaceStatistics(points.positions, array, Medium(), {q}, statistics),
                 midair::base::Stopped);

    CertificateOptions certificate;
    certificate.stop = source.token();
    EXPECT_THROW(Certifier(certificate).certify(points, array, Medium(), q), midair::base::Stopped);

    SamplerOptions sampler;
    sampler.stop = source.token();
    EXPECT_THROW(
        sampleSurface(test::makeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), sampler),
        midair::base::Stopped);

    OutlineOptions outline;
    outline.stop = source.token();
    Eigen::VectorXcf played;
    EXPECT_THROW(OutlineHologram(outline).solve(
                     {Outline::circle({0, 0, 0.15}, 0.04, {0, 0, 1})}, array, Medium(), played),
                 midair::base::Stopped);

    ComposerOptions composer;
    composer.solverOptions.stop = source.token();
    midair::base::MessageLog messages;
    EXPECT_THROW(SequenceComposer(composer, messages).compose(0, points, {}, array, Medium()),
                 midair::base::Stopped);

    const std::vector<BudgetPoint> crowd(4, BudgetPoint{0, 0, 0, 0, Eigen::Vector3d::Zero()});
    EXPECT_THROW(shareBudget(crowd, 2, source.token()), midair::base::Stopped);
}

TEST(Stop, OutlinesAndSweepsAndSamplersAreBrokenOffWhileTheyWork)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const auto broken = [](const auto& work)
    {
        midair::base::StopSource source;
        const Later later(source);
        const StdClock::time_point start = StdClock::now();
        EXPECT_THROW(work(source.token()), midair::base::Stopped);
        EXPECT_LT(since_s(start), kSoon_s);
    };
    broken(
        [&](const midair::base::StopToken& stop)
        {
            OutlineOptions options;
            options.starts = 1000;
            options.stop = stop;
            Eigen::VectorXcf q;
            OutlineHologram(options).solve(
                {Outline::circle({0, 0, 0.15}, 0.1, {0, 0, 1})}, array, Medium(), q);
        });
    broken(
        [&](const midair::base::StopToken& stop)
        {
            ComposerOptions options;
            options.even = 1000;
            options.solverOptions.stop = stop;
            const ControlPoints points = spherePoints(20, 0.02, {0.0, 0.0, 0.15});
            midair::base::MessageLog messages;
            SequenceComposer(options, messages)
                .composeCycle(std::vector<ControlPoints>(32, points),
                              spherePoints(5000, 0.1, {0.0, 0.0, 0.15}),
                              array,
                              Medium());
        });
    broken(
        [&](const midair::base::StopToken& stop)
        {
            SamplerOptions options;
            options.spacing_m = 1e-3;
            options.maxPoints = 1000000000;
            options.stop = stop;
            sampleSurface(test::makeMesh({{0, 0, 0}, {20, 0, 0}, {0, 20, 0}}, {{0, 1, 2}}),
                          options);
        });
    broken(
        [&](const midair::base::StopToken& stop)
        {
            CertificateOptions options;
            options.stop = stop;
            options.batches = 100000;
            Certifier(options).certify(spherePoints(400, 0.03, {0.0, 0.0, 0.15}), array, Medium());
        });
}

TEST(Stop, AMonitorThatIsEndedBreaksOffItsCertificate)
{
    FieldMonitor::Options options;
    options.interval_s = 0.0;
    options.certificate.batches = 1000000;
    auto monitor = std::make_unique<FieldMonitor>(options);
    auto field = std::make_shared<PlayedField>();
    field->points = spherePoints(200, 0.03, {0.0, 0.0, 0.15});
    field->array = std::make_shared<const TransducerArray>(TransducerArray::singleBoard());
    field->q = Eigen::VectorXcf::Ones(field->array->size());
    ASSERT_TRUE(eventually([&] { return monitor->isWaiting(); }));
    monitor->submit(field);
    ASSERT_TRUE(eventually([&] { return !monitor->isWaiting(); }));
    const StdClock::time_point start = StdClock::now();
    monitor.reset();
    EXPECT_LT(since_s(start), kSoon_s);
}

TEST(Limits, ACertificateIsForSoManyPoints)
{
    try
    {
        Certifier().certify(spherePoints(midair::base::kMostCertifiedPoints + 1, 0.03),
                            TransducerArray::singleBoard(),
                            Medium());
        ADD_FAILURE() << "no error";
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_STREQ(error.what(),
                     "certificate: there are 1001 control points; at most 1000 are certified");
    }
}

TEST(Limits, AMeshOfTooManyTrianglesIsRefusedBeforeItIsLookedAt)
{
    TriangleMesh mesh = test::makeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {});
    mesh.triangles.setZero(3, midair::base::kMostTriangles + 1);
    try
    {
        sampleSurface(mesh, {});
        ADD_FAILURE() << "no error";
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_STREQ(error.what(), "The mesh has 4000001 triangles; there must be at most 4000000");
    }
}

TEST(Limits, OutlinesOfAHugeLengthAreRefusedBeforeTheyArePlaced)
{
    // A thousand of them, each within what one outline may have, are 100 million places where
    // pressure would be judged.
    const std::vector<Outline> outlines(1000, Outline::line({0, 0, 0.1}, {80, 0, 0.1}));
    const StdClock::time_point start = StdClock::now();
    Eigen::VectorXcf q;
    EXPECT_THROW(OutlineHologram().solve(outlines, TransducerArray::singleBoard(), Medium(), q),
                 midair::base::InputError);
    EXPECT_LT(since_s(start), kSoon_s);
}
