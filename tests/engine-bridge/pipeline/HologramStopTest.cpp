// Closing, new settings and silence don't wait for a solve.
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/ThreadPool.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using Clock = std::chrono::steady_clock;

namespace
{

// What used to take half a minute and more; milliseconds now, on a machine with a core to spare.
constexpr double kSoon_s = 15.0;

double since_s(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A real solver that tells when it begins.
HologramOptions solverOptions(const std::shared_ptr<FakeLog>& log, const std::string& name)
{
    HologramOptions options = fakeOptions(log);
    options.solver = name;
    options.solverOptions.maxIterations = 1000000;
    options.solverOptions.rmsTolerance = 0.0;
    options.solverFactory = [log](const std::string& solver, const haptics::SolverOptions& o)
    {
        struct Telling : haptics::HologramSolver
        {
            haptics::SolveReport solve(const haptics::ControlPoints& points,
                                       const haptics::TransducerArray& array,
                                       const haptics::Medium& medium,
                                       Eigen::VectorXcf& q) override
            {
                ++log->solves;
                return inner->solve(points, array, medium, q);
            }
            const haptics::SolverOptions& options() const override { return inner->options(); }
            std::shared_ptr<FakeLog> log;
            std::unique_ptr<haptics::HologramSolver> inner;
        };
        auto telling = std::make_unique<Telling>();
        telling->log = log;
        telling->inner = haptics::makeSolver(solver, o);
        return telling;
    };
    return options;
}

SceneSnapshot sphereSnapshot(double x_m = 0.0)
{
    SceneSnapshot snapshot = squareSnapshot(x_m);
    snapshot.objects[0].meshId = 2;
    snapshot.objects[0].mesh = sphere(0.03, 12);
    return snapshot;
}

class Closing : public testing::TestWithParam<std::string>
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

INSTANTIATE_TEST_SUITE_P(All, Closing, testing::Values("sdp-bcd", "wgs", "greedy"), plainName);

TEST_P(Closing, BreaksOffASolveOfAMillionIterations)
{
    auto log = std::make_shared<FakeLog>();
    auto thread = std::make_unique<HologramThread>(solverOptions(log, GetParam()));
    SceneSnapshot snapshot = sphereSnapshot();
    thread->submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 1; }));
    const Clock::time_point start = Clock::now();
    thread.reset();
    EXPECT_LT(since_s(start), kSoon_s);
    EXPECT_EQ(log->sends, 0) << "what was broken off is not played";
    EXPECT_GE(log->silences, 1);
    EXPECT_EQ(log->closed, 1);
}

TEST(HologramStop, SilenceDoesNotWaitForASolverThatNeverLooks)
{
    auto log = std::make_shared<FakeLog>();
    log->hold = true;
    HologramThread thread(fakeOptions(log));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 1; }));
    const int before = log->silences;
    snapshot.objects.clear();
    snapshot.frame = 2;
    thread.submit(snapshot);
    EXPECT_GT(log->silences, before) << "by the time that submit() is back";
    EXPECT_EQ(log->solves, 1);
    log->hold = false;
    ASSERT_TRUE(
        eventually([&] { return thread.latestResult() && thread.latestResult()->frame == 2; }));
    EXPECT_EQ(log->sends, 0) << "the field that was being solved is not played after the silence";
    EXPECT_EQ(thread.latestResult()->report().stop, haptics::StopReason::NOTHING_TO_DO);

    snapshot = squareSnapshot(0.001);
    thread.submit(snapshot);
    EXPECT_TRUE(eventually([&] { return log->sends == 1; })) << "what comes next is played";
}

TEST(HologramStop, SilenceHoldsForFieldsInTurnToo)
{
    auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.modulation.amplitudeRate_Hz = 100.0;
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->sends > 10; }));
    log->hold = true;
    snapshot = squareSnapshot(0.005);
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 2; }));
    snapshot.objects.clear();
    thread.submit(snapshot);
    const int sent = log->sends;
    EXPECT_TRUE(othersSend(30));
    EXPECT_EQ(log->sends, sent) << "nothing is sent any more while the solve goes on";
    log->hold = false;
}

TEST(HologramStop, ClosingSilencesBeforeASolverThatNeverLooksIsDone)
{
    auto log = std::make_shared<FakeLog>();
    auto thread = std::make_unique<HologramThread>(fakeOptions(log));
    SceneSnapshot snapshot = squareSnapshot();
    thread->submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->sends == 1; }));
    log->hold = true;
    snapshot = squareSnapshot(0.005);
    thread->submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 2; }));
    const int before = log->silences;
    std::thread closing([&] { thread.reset(); });
    EXPECT_TRUE(eventually([&] { return log->silences > before; }));
    EXPECT_EQ(log->closed, 0);
    log->hold = false;
    closing.join();
    EXPECT_EQ(log->sends, 1);
}

TEST(HologramStop, NewSettingsBreakOffTheSolveOfTheOld)
{
    auto first = std::make_shared<FakeLog>();
    auto second = std::make_shared<FakeLog>();
    HologramThread thread(solverOptions(first, "sdp-bcd"));
    SceneSnapshot snapshot = sphereSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return first->solves == 1; }));
    thread.setPipeline([second]
                       { return std::make_unique<HologramPipeline>(fakeOptions(second)); });
    ASSERT_TRUE(eventually([&] { return thread.latestResult() != nullptr; }));
    EXPECT_EQ(thread.latestResult()->report().stop, haptics::StopReason::STOPPED);
    EXPECT_FALSE(thread.latestResult()->playing);
    EXPECT_EQ(first->sends, 0);
    snapshot = sphereSnapshot();
    thread.submit(snapshot);
    EXPECT_TRUE(eventually([&] { return second->sends == 1; }));
    EXPECT_EQ(first->closed, 1);
}

TEST(HologramStop, ASnapshotBehindOneThatIsSolvedStillWaits)
{
    auto log = std::make_shared<FakeLog>();
    log->hold = true;
    HologramThread thread(fakeOptions(log));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 1; }));
    snapshot = squareSnapshot(0.005);
    thread.submit(snapshot);
    log->hold = false;
    ASSERT_TRUE(eventually([&] { return log->sends == 2; }))
        << "only silence and new settings break off a solve";
}

TEST(HologramStop, WhatIsMadeAtRestForLongGivesWayToWhatMoves)
{
    // The fields of the first snapshot, and of what moved, are there at once; the other set of the
    // cycle never is.
    struct Endless : FakeSolver
    {
        using FakeSolver::FakeSolver;
        haptics::SolveReport solve(const haptics::ControlPoints& points,
                                   const haptics::TransducerArray& array,
                                   const haptics::Medium& medium,
                                   Eigen::VectorXcf& q) override
        {
            const haptics::SolveReport report = FakeSolver::solve(points, array, medium, q);
            if (endless) eventually([this] { return options().stop.requested(); });
            options().stop.throwIfRequested();
            return report;
        }
        bool endless = false;
    };
    auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.cycle = 2;
    auto made = std::make_shared<int>(0);
    options.solverFactory = [log, made](const std::string&, const haptics::SolverOptions& o)
    {
        auto solver = std::make_unique<Endless>(log, o);
        solver->endless = ++*made == 3; // the first is only made to see whether it can be
        return solver;
    };
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 2; }));
    const int silences = log->silences;
    // Only what is made for half a second gives way. Either set's turn may come: the endless one's
    // next solve is broken off by the silence at the end.
    EXPECT_TRUE(eventually(
        [&]
        {
            snapshot = squareSnapshot(0.005);
            snapshot.frame = 7;
            thread.submit(snapshot);
            return log->solves == 3;
        }));
    EXPECT_EQ(log->silences, silences) << "what is played goes on";
}

TEST(HologramStop, SixtyFourSubsetsOn256ThreadsCloseSoon)
{
    auto log = std::make_shared<FakeLog>();
    HologramOptions options = solverOptions(log, "gauss-newton");
    options.solverOptions.threads = 256;
    options.subsets = 64;
    options.maxPoints = 1000;
    auto thread = std::make_unique<HologramThread>(options);
    SceneSnapshot snapshot = sphereSnapshot();
    snapshot.objects[0].mesh = sphere(0.06, 20);
    snapshot.objects[0].properties.spacing_m = 0.006;
    thread->submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves >= 2; }));
    const Clock::time_point start = Clock::now();
    thread.reset();
    EXPECT_LT(since_s(start), kSoon_s);
}

TEST(HologramLimits, WhatIsAskedForBeyondThemIsSaidAndNotDone)
{
    auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.solverOptions.threads = 256;
    options.maxPoints = 1000000;
    options.cycle = 64;
    options.cycleSteps = 16;
    options.subsets = 64;
    options.monitorInterval = 1e-9;
    const HologramPipeline pipeline(options);
    const int cores = base::coreCount();
    ASSERT_LT(cores, 256);
    EXPECT_EQ(pipeline.options().solverOptions.threads, cores);
    EXPECT_EQ(pipeline.options().maxPoints, base::kMostControlPoints);
    EXPECT_EQ(pipeline.options().subsets, 4);
    EXPECT_EQ(pipeline.options().cycleSteps, 3);
    EXPECT_EQ(pipeline.options().monitorInterval, 0.05);
    const std::vector<std::string>& said = pipeline.messages();
    ASSERT_EQ(said.size(), 5u);
    EXPECT_EQ(said[0].rfind("threads is 256; this machine has " + std::to_string(cores), 0), 0u);
    EXPECT_EQ(said[1],
              "maxPoints is 1000000; the control points of a field of this array are at most 5000");
    EXPECT_EQ(said[2], "subsets is 64; with a cycle of 64 it is at most 4");
    EXPECT_EQ(said[3], "cycleSteps is 16; with a cycle of 64 it is at most 3");
    EXPECT_EQ(said[4], "monitorInterval is 1e-09; fields are checked every 0.05 s at most");
}

TEST(HologramLimits, ObjectsBeyondTheSamplesOfASceneAreLeftOutByName)
{
    auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(fakeOptions(log));
    // Fifteen instances of one mesh, of 15,000 samples and more each.
    SceneSnapshot snapshot = squareSnapshot();
    HapticObject object = snapshot.objects[0];
    object.mesh = squareMesh(0.05);
    object.properties.spacing_m = 0.05 / 145.0;
    snapshot.objects.clear();
    for (int i = 0; i < 15; ++i)
    {
        object.id = static_cast<std::uint64_t>(i + 1);
        object.path = "Scene/" + std::to_string(i);
        snapshot.objects.push_back(object);
    }
    pipeline.process(snapshot);
    bool said = false;
    for (const std::string& message : pipeline.messages())
        said = said || (message.rfind("Scene/14: with its ", 0) == 0 &&
                        message.find("more than 200000 together") != std::string::npos);
    EXPECT_TRUE(said);
}
