// Options that change while the device stays open.
#include "engine-bridge/pipeline/HologramThread.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <atomic>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// The real solver on a simulated array.
HologramOptions simulatedOn(const std::string& uri = "sim:")
{
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.deviceUri = uri;
    return options;
}

double loudest(const HologramResult& result)
{
    return result.played().cwiseAbs().maxCoeff();
}

} // namespace

TEST(HologramPipeline, ReconfiguredKeepsDeviceCountersAndTheLastFieldAsItsStart)
{
    HologramPipeline pipeline(simulatedOn());
    const auto before = pipeline.process(squareSnapshot());
    ASSERT_GT(before->points.size(), 0);
    HologramOptions options = simulatedOn();
    options.solverOptions.loudness = 0.5;
    pipeline.reconfigure(options);
    const auto after = pipeline.process(squareSnapshot());
    EXPECT_NE(after, before) << "solved, though nothing moved";
    EXPECT_EQ(after->report().rowsBuilt, 0) << "of the same points";
    EXPECT_LT(after->report().meanPhaseStep_rad, 0.1) << "not a field that began anew";
    EXPECT_NEAR(after->report().level_Pa,
                0.5 * before->report().level_Pa,
                0.02 * before->report().level_Pa);
    EXPECT_EQ(after->counters.solves, 2u);
    EXPECT_EQ(after->counters.snapshots, 2u);
    EXPECT_EQ(after->counters.meshesSampled, 1u);
    EXPECT_EQ(pipeline.device().reading().fields.sent, 2u);
    EXPECT_EQ(pipeline.process(squareSnapshot()), after) << "once is enough";
}

TEST(HologramPipeline, ReconfiguredSolvesAnewInOtherAirAndWithAnotherSolver)
{
    HologramPipeline pipeline(simulatedOn());
    pipeline.process(squareSnapshot());
    HologramOptions options = simulatedOn();
    options.medium.temperature_C = 35.0;
    pipeline.reconfigure(options);
    const auto warmer = pipeline.process(squareSnapshot());
    EXPECT_EQ(warmer->report().rowsBuilt, warmer->report().points);
    options.solver = haptics::solverNames().back();
    pipeline.reconfigure(options);
    EXPECT_EQ(pipeline.process(squareSnapshot())->report().solver, options.solver);
    EXPECT_EQ(pipeline.device().reading().fields.sent, 3u);
}

TEST(CappedPipeline, ReconfiguredIsSilentUntilAStricterCapIsKept)
{
    HologramPipeline pipeline(simulatedOn());
    const auto before = pipeline.process(squareSnapshot());
    const float before_Pa = before->achieved_Pa.maxCoeff();
    HologramOptions options = simulatedOn();
    options.maxPressure = 0.25 * before_Pa;
    const std::uint64_t sent = pipeline.device().reading().fields.sent;
    pipeline.reconfigure(options);
    EXPECT_EQ(pipeline.attend(), nullptr);
    EXPECT_EQ(pipeline.device().reading().fields.sent, sent);
    const auto after = pipeline.process(squareSnapshot());
    EXPECT_TRUE(after->playing);
    EXPECT_LE(after->achieved_Pa.maxCoeff(), options.maxPressure);
    EXPECT_GT(after->achieved_Pa.maxCoeff(), 0.5 * options.maxPressure);
    // and back
    pipeline.reconfigure(simulatedOn());
    EXPECT_NEAR(
        pipeline.process(squareSnapshot())->achieved_Pa.maxCoeff(), before_Pa, 0.05 * before_Pa);
}

TEST(CappedPipeline, ALowerAmplitudeHoldsForWhatPlaysAlready)
{
    HologramPipeline pipeline(simulatedOn("sim:?max-amplitude=0.6"));
    EXPECT_NEAR(loudest(*pipeline.process(squareSnapshot())), 0.6, 0.01);
    HologramOptions options = simulatedOn();
    options.maxAmplitude = 0.3;
    pipeline.device().lowerAmplitudeCap(options.maxAmplitude);
    EXPECT_EQ(pipeline.device().reading().fields.sent, 2u) << "the same field, lowered";
    pipeline.reconfigure(options);
    EXPECT_LE(loudest(*pipeline.process(squareSnapshot())), 0.3);
    options.maxAmplitude = 1.0;
    pipeline.reconfigure(options);
    EXPECT_LE(loudest(*pipeline.process(squareSnapshot())), 0.6)
        << "what the device was opened with";
}

TEST(CappedPipeline, ADeviceThatKeepsNoCapIsSilent)
{
    auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(fakeOptions(log)); // no GuardedDevice around it
    EXPECT_TRUE(pipeline.process(squareSnapshot())->playing);
    HologramOptions options = fakeOptions(log);
    options.maxAmplitude = 0.5;
    pipeline.reconfigure(options);
    const int sends = log->sends;
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_FALSE(result->playing);
    EXPECT_EQ(log->sends, sends);
    EXPECT_EQ(result->state, ArrayState::FAULT);
    EXPECT_EQ(result->messages.back(),
              "the device can't apply an amplitude cap; nothing is played");
}

TEST(HologramPipeline, OptionsThatAreNotValidPlayNothingUntilThereAreOthers)
{
    for (const bool isSolver : {false, true})
    {
        HologramPipeline pipeline(simulatedOn());
        ASSERT_TRUE(pipeline.process(squareSnapshot())->playing);
        HologramOptions wrong = simulatedOn();
        if (isSolver)
            wrong.solver = "nonsense";
        else
            wrong.maxPressure = std::numeric_limits<double>::quiet_NaN();
        pipeline.reconfigure(wrong);
        const auto refused = pipeline.process(squareSnapshot());
        EXPECT_FALSE(refused->playing);
        EXPECT_EQ(loudest(*refused), 0.0);
        EXPECT_EQ(refused->report().stop, haptics::StopReason::REFUSED);
        EXPECT_FALSE(refused->report().message.empty());
        pipeline.reconfigure(simulatedOn());
        EXPECT_TRUE(pipeline.process(squareSnapshot())->playing);
    }
}

TEST(HologramThread, OtherOptionsLeaveTheDeviceOpenAndOfASolveUnderWayNothingIsLost)
{
    auto log = std::make_shared<FakeLog>();
    log->hold = true;
    HologramThread thread(fakeOptions(log));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return log->solves == 1; }));
    HologramOptions louder = fakeOptions(log);
    louder.solverOptions.loudness = 0.7;
    thread.setOptions(louder, [] { return nullptr; });
    log->hold = false;
    ASSERT_TRUE(eventually([&] { return thread.results() == 1; }));
    EXPECT_TRUE(thread.latestResult()->playing) << "the field that was being solved";
    snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() == 2; }));
    EXPECT_EQ(log->closed, 0);
    EXPECT_EQ(log->solves, 2);
    EXPECT_EQ(thread.counters().solves, 2u);
}

TEST(HologramThread, AStricterCapSilencesBeforeTheNextSnapshot)
{
    auto log = std::make_shared<FakeLog>();
    HologramThread thread(fakeOptions(log));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() == 1; }));
    const int silences = log->silences;
    HologramOptions stricter = fakeOptions(log);
    stricter.maxPressure = 1e5;
    thread.setOptions(stricter, [] { return nullptr; });
    EXPECT_GT(log->silences, silences) << "before setOptions() returns";
}

TEST(HologramThread, ACapThatComesWhileTheDeviceIsBeingOpenedHoldsForTheFirstField)
{
    const float free_Pa =
        HologramPipeline(simulatedOn()).process(squareSnapshot())->achieved_Pa.maxCoeff();
    for (const char* cap : {"amplitude", "pressure", "ears"})
    {
        HologramOptions strict = simulatedOn();
        if (cap[0] == 'a') strict.maxAmplitude = 0.2;
        if (cap[0] == 'p') strict.maxPressure = 0.2 * static_cast<double>(free_Pa);
        if (cap[0] == 'e') strict.earLimit = 100.0;
        for (const bool isMadeAgain : {false, true})
        {
            Halt opening(!isMadeAgain);
            std::atomic<int> made{0};
            std::atomic<bool> stale{false};
            const auto make = [&](const HologramOptions& options)
            {
                return [&, options]
                {
                    ++made;
                    opening.pass();
                    return std::make_unique<HologramPipeline>(options);
                };
            };
            HologramThread thread(make(simulatedOn()), [&] { return stale.exchange(false); });
            SceneSnapshot snapshot = squareSnapshot();
            thread.submit(snapshot);
            if (isMadeAgain) // as when the array's file has changed
            {
                ASSERT_TRUE(eventually([&] { return thread.results() > 0; }));
                opening = true;
                stale = true;
            }
            ASSERT_TRUE(eventually([&] { return made == (isMadeAgain ? 2 : 1); }));
            const std::uint64_t before = thread.results();
            thread.setOptions(strict, make(strict));
            opening = false;
            ASSERT_TRUE(eventually([&] { return thread.results() > before; }));
            const auto first = thread.latestResult();
            EXPECT_LE(first->achieved_Pa.maxCoeff(), 0.21f * free_Pa) << cap << isMadeAgain;
            EXPECT_LE(thread.reading().fields.sent, 1u) << "what was sent is that field";
        }
    }
}

TEST(HologramThread, OptionsMakeAPipelineWhereThereIsNone)
{
    auto log = std::make_shared<FakeLog>();
    HologramOptions wrong = fakeOptions(log);
    wrong.fieldRate = -1.0;
    HologramThread thread(wrong);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() == 1; }));
    EXPECT_EQ(thread.state(), ArrayState::CLOSED);
    thread.setOptions(fakeOptions(log),
                      [log] { return std::make_unique<HologramPipeline>(fakeOptions(log)); });
    snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() == 2; }));
    EXPECT_TRUE(thread.latestResult()->playing);
    EXPECT_EQ(thread.state(), ArrayState::PLAYING);
}

TEST(HologramThread, AMuteIsSilentAtOnceAndEndsByItself)
{
    HologramThread thread(simulatedOn());
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    const std::uint64_t sent = thread.reading().fields.sent;
    thread.setMuted(true);
    EXPECT_EQ(thread.state(), ArrayState::MUTED);
    ASSERT_TRUE(eventually([&] { return thread.latestResult()->state == ArrayState::MUTED; }));
    EXPECT_EQ(thread.latestResult()->achieved_Pa.maxCoeff(), 0.0f);
    // what moves meanwhile is solved and shown, but not sent
    snapshot = squareSnapshot(0.01);
    snapshot.frame = 7;
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.latestResult()->frame == 7; }));
    EXPECT_EQ(thread.reading().fields.sent, sent);
    thread.setMuted(false);
    ASSERT_TRUE(eventually([&] { return thread.latestResult()->state == ArrayState::PLAYING; }));
    EXPECT_EQ(thread.reading().fields.sent, sent + 1);
    EXPECT_GT(thread.latestResult()->achieved_Pa.maxCoeff(), 0.0f);
}

TEST(HologramThread, APipelineThatIsMadeAgainHasTheNewestOptions)
{
    const auto making = [](double maxAmplitude)
    {
        return [maxAmplitude]
        {
            HologramOptions options = simulatedOn();
            options.maxAmplitude = maxAmplitude;
            return std::make_unique<HologramPipeline>(options);
        };
    };
    std::atomic<bool> stale{false}; // as when the array's file has changed
    HologramThread thread(making(1.0), [&] { return stale.exchange(false); });
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() > 0; }));
    ASSERT_GT(loudest(*thread.latestResult()), 0.9);
    HologramOptions capped = simulatedOn();
    capped.maxAmplitude = 0.2;
    thread.setOptions(capped, making(0.2));
    snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return loudest(*thread.latestResult()) <= 0.2; }));
    const auto before = thread.latestResult();
    stale = true;
    ASSERT_TRUE(eventually([&] { return thread.latestResult() != before && !stale; }));
    EXPECT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    EXPECT_LE(loudest(*thread.latestResult()), 0.2);
    EXPECT_EQ(thread.reading().fields.sent, 1u) << "by another device";
}

TEST(HologramThread, AMuteEndsForFieldsInTurnToo)
{
    HologramOptions options = simulatedOn();
    options.subsets = 2;
    HologramThread thread(options);
    thread.setMuted(true); // before there is a device
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() > 0; }));
    EXPECT_EQ(thread.state(), ArrayState::MUTED);
    EXPECT_EQ(thread.reading().fields.sent, 0u);
    thread.setMuted(false);
    EXPECT_TRUE(eventually([&] { return thread.reading().fields.played > 10; }));
    thread.setMuted(true);
    const std::uint64_t sent = thread.reading().fields.sent;
    EXPECT_TRUE(othersSend(30));
    EXPECT_EQ(thread.reading().fields.sent, sent) << "no steps that are refused";
}

TEST(HologramThread, ADeviceThatPlaysNothingIsAFaultAndIsToldOnce)
{
    for (const char* uri : {"sim:?drop=1", "sim:?corrupt=1"})
    {
        HologramThread thread(simulatedOn(uri));
        int frame = 0;
        ASSERT_TRUE(eventually(
            [&]
            {
                SceneSnapshot snapshot = squareSnapshot(1e-4 * ++frame);
                thread.submit(snapshot);
                return thread.state() == ArrayState::FAULT;
            }))
            << uri;
        EXPECT_EQ(thread.reading().fields.played, 0u);
        EXPECT_GT(thread.reading().fields.lost, 0u);
        ASSERT_TRUE(eventually([&] { return !thread.latestResult()->told.empty(); }));
        const auto told = thread.latestResult()->told;
        ASSERT_EQ(told.size(), 1u);
        EXPECT_EQ(told[0].code, base::MessageCode::DEVICE_FAULT);
        EXPECT_EQ(told[0].text.rfind("device: ", 0), 0u) << told[0].text;
    }
}

TEST(HologramThread, ADeviceThatHangsIsAFaultAtRest)
{
    HologramOptions options = simulatedOn("sim:?hang_at=300ms");
    options.restAfter_s = std::numeric_limits<double>::infinity(); // nothing more is sent
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::FAULT; }));
    EXPECT_TRUE(eventually([&] { return thread.latestResult()->achieved_Pa.maxCoeff() == 0.0f; }));
    EXPECT_EQ(thread.reading().fields.played, 1u);
}

TEST(HologramThread, ADeviceThatIsUnpluggedIsLostAndThenPlaysAgain)
{
    HologramThread thread(simulatedOn("sim:?unplug_at=200ms&replug_at=1200ms"));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::LOST; }));
    EXPECT_NE(thread.reading().status.find("; unplugged"), std::string::npos)
        << thread.reading().status;
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    EXPECT_EQ(thread.reading().status.find("; unplugged"), std::string::npos)
        << thread.reading().status;
    EXPECT_NE(thread.reading().status.find("; last fault: unplugged"), std::string::npos);
    EXPECT_EQ(thread.reading().fields.reconnects, 1u);
}
