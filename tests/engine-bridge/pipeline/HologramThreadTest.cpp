#include "engine-bridge/pipeline/HologramThread.h"

#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#include <gtest/gtest.h>
#include <sys/prctl.h>

using namespace midair::bridge;

TEST(HologramThread, ASubmittedSnapshotIsPlayed)
{
    auto log = std::make_shared<FakeLog>();
    HologramThread thread(fakeOptions(log));
    EXPECT_EQ(thread.latestResult(), nullptr);
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.frame = 42;
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.latestResult() != nullptr; }));
    EXPECT_EQ(thread.latestResult()->frame, 42u);
    EXPECT_GT(thread.latestResult()->latency_ms, 0.0);
}

// Its solver and its device run on it.
TEST(HologramThread, ItsWaitsEndWhenTheyAreDue)
{
    const int own_ns = prctl(PR_GET_TIMERSLACK);
    EXPECT_GT(own_ns, 1) << "of this thread, which doesn't play";
    std::atomic<int> slack_ns{0};
    HologramThread thread(
        [&]
        {
            slack_ns = prctl(PR_GET_TIMERSLACK);
            return std::make_unique<HologramPipeline>(fakeOptions(std::make_shared<FakeLog>()));
        });
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.latestResult() != nullptr; }));
    EXPECT_EQ(slack_ns, 1);
    EXPECT_EQ(prctl(PR_GET_TIMERSLACK), own_ns);
}

TEST(HologramThread, SubmitDoesNotWaitForASolverThatSleeps)
{
    auto log = std::make_shared<FakeLog>();
    log->hold = true;
    HologramThread thread(fakeOptions(log));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 1; }));
    // The first solve doesn't end before all are handed over: were submit() to wait for it, the
    // test would hang.
    for (int i = 1; i <= 100; ++i)
    {
        snapshot = squareSnapshot(1e-3 * i);
        snapshot.frame = static_cast<std::uint64_t>(i);
        thread.submit(snapshot);
        thread.latestResult();
        thread.counters();
    }
    EXPECT_EQ(log->solves, 1);
    log->hold = false;
    ASSERT_TRUE(
        eventually([&] { return thread.latestResult() && thread.latestResult()->frame == 100; }))
        << "the newest wins";
    EXPECT_EQ(log->solves, 2);
    EXPECT_EQ(thread.counters().superseded, 99u);
    EXPECT_EQ(thread.counters().snapshots, 101u);
}

TEST(HologramThread, StoppingInTheMiddleOfASolveIsCleanAndSilent)
{
    auto log = std::make_shared<FakeLog>();
    log->hold = true;
    std::thread later;
    {
        HologramThread thread(fakeOptions(log));
        SceneSnapshot snapshot = squareSnapshot();
        thread.submit(snapshot);
        ASSERT_TRUE(eventually([&] { return log->solves == 1; }));
        snapshot = squareSnapshot(0.01);
        thread.submit(snapshot);
        later = std::thread(
            [log]
            {
                EXPECT_TRUE(eventually([&] { return log->silences > 0; })); // it is being stopped
                log->hold = false;
            });
    }
    later.join();
    EXPECT_EQ(log->solves, 1) << "what waits in the slot is not begun";
    EXPECT_GE(log->silences, 1);
    EXPECT_EQ(log->closed, 1);
}

TEST(HologramThread, StoppingWithoutASnapshotOpensNoDevice)
{
    auto log = std::make_shared<FakeLog>();
    {
        HologramThread thread(fakeOptions(log));
    }
    EXPECT_EQ(log->closed, 0);
}

TEST(HologramThread, WhatThePipelineCannotBeMadeForIsAMessage)
{
    HologramThread thread(HologramOptions{});
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.latestResult() != nullptr; }));
    EXPECT_EQ(thread.latestResult()->report().stop, midair::haptics::StopReason::REFUSED);
    EXPECT_EQ(thread.latestResult()->report().message,
              "array \"\" has no transducers; it must have at least one");
}

TEST(HologramThread, WhateverAnApplicationsCodeThrowsIsAMessage)
{
    const std::string what = "something was thrown that is no std::exception";
    const auto log = std::make_shared<FakeLog>();
    HologramThread thread([]() -> std::unique_ptr<HologramPipeline> { throw 5; });
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.latestResult() != nullptr; }));
    EXPECT_EQ(thread.latestResult()->report().stop, midair::haptics::StopReason::REFUSED);
    EXPECT_EQ(thread.latestResult()->report().message, what);

    log->throwNumber = true;
    thread.setPipeline([log] { return std::make_unique<HologramPipeline>(fakeOptions(log)); });
    const std::uint64_t before = thread.results();
    snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() > before; }));
    EXPECT_EQ(thread.latestResult()->report().stop, midair::haptics::StopReason::REFUSED);
    EXPECT_EQ(thread.latestResult()->report().message, what);
    EXPECT_EQ(log->sends, 0);

    log->throwNumber = false;
    snapshot = squareSnapshot(1e-3);
    thread.submit(snapshot);
    EXPECT_TRUE(eventually([&] { return log->sends > 0; }));
}

TEST(HologramThread, ANewPipelineTakesOverAfterTheOldOneIsClosed)
{
    auto first = std::make_shared<FakeLog>();
    auto second = std::make_shared<FakeLog>();
    HologramThread thread(fakeOptions(first));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return first->sends == 1; }));
    int closedBefore = -1;
    thread.setPipeline(
        [first, second, &closedBefore]
        {
            closedBefore = first->closed;
            return std::make_unique<HologramPipeline>(fakeOptions(second));
        });
    snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return second->sends == 1; }));
    EXPECT_EQ(closedBefore, 1) << "a device is closed before it is opened again";
}

TEST(HologramThread, SnapshotsGoRoundWithoutNewMemory)
{
    auto log = std::make_shared<FakeLog>();
    HologramThread thread(fakeOptions(log));
    std::vector<const HapticObject*> seen;
    SceneSnapshot snapshot;
    for (int i = 0; i < 50; ++i)
    {
        snapshot.objects.resize(1);
        snapshot.objects[0] = squareSnapshot(1e-3 * i).objects[0];
        if (std::find(seen.begin(), seen.end(), snapshot.objects.data()) == seen.end())
            seen.push_back(snapshot.objects.data());
        snapshot.frame = static_cast<std::uint64_t>(i);
        thread.submit(snapshot);
        if (i % 3 != 0) continue;
        ASSERT_TRUE(
            eventually([&, frame = static_cast<std::uint64_t>(i)]
                       { return thread.latestResult() && thread.latestResult()->frame == frame; }));
    }
    EXPECT_LE(seen.size(), 3u) << "the producer's, the slot's and the consumer's";
}
