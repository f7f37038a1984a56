#include "engine-bridge/player/ScenePlayer.h"

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/player/SceneOptions.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/device/limits/UserCapTexts.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>

#include <gtest/gtest.h>

using namespace midair::bridge;
using midair::base::Message;

namespace
{

/// A player of a square above the octagon, on fakes.
struct Played
{
    Played() :
        player({{},
                [](const std::string& uri) { return openHands(uri); },
                [this](HologramOptions& options)
                {
                    const HologramOptions fakes = fakeOptions(log);
                    options.solverFactory = fakes.solverFactory;
                    options.deviceFactory = fakes.deviceFactory;
                }})
    {
    }

    void configure()
    {
        PlayedOn on;
        on.array = "octagon";
        on.device = device;
        player.configure(std::make_shared<const SceneSettings>(settings), on, "a test");
    }
    bool frame(double x_m = 0.0)
    {
        player.refresh();
        player.snapshot() = squareSnapshot(x_m);
        return player.play(Eigen::Isometry3d::Identity());
    }
    bool plays()
    {
        return eventually(
            [&]
            {
                frame();
                return player.state() == ArrayState::PLAYING;
            });
    }
    bool says(const std::string& words) const
    {
        const std::vector<Message> all = player.log().messages();
        return std::any_of(all.begin(),
                           all.end(),
                           [&](const Message& one)
                           { return one.text.find(words) != std::string::npos; });
    }

    std::shared_ptr<FakeLog> log = std::make_shared<FakeLog>();
    SceneSettings settings;
    std::string device = "sim:";
    ScenePlayer player;
};

} // namespace

TEST(ScenePlayer, NothingIsOpenedBeforeItIsConfigured)
{
    Played of;
    EXPECT_FALSE(of.frame());
    EXPECT_EQ(of.player.state(), ArrayState::CLOSED);
    EXPECT_TRUE(of.player.isClosed());
    EXPECT_EQ(of.player.array(), nullptr);
    of.configure();
    EXPECT_TRUE(of.plays());
    ASSERT_NE(of.player.array(), nullptr);
    EXPECT_EQ(of.player.array()->size(), 3984);
}

TEST(ScenePlayer, WhatHasNotMovedIsNotHandedOver)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    EXPECT_FALSE(of.frame());
    const SceneStatistics before = of.player.statistics();
    EXPECT_FALSE(of.frame());
    EXPECT_TRUE(of.frame(0.001));
    const SceneStatistics after = of.player.statistics();
    EXPECT_EQ(after.frames, before.frames + 2);
    EXPECT_EQ(after.idleFrames, before.idleFrames + 1);
    EXPECT_EQ(after.snapshots, before.snapshots + 1);
}

TEST(ScenePlayer, OnlyWhatAChangeNeedsIsDoneAnew)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    const std::uint64_t changes = of.player.changes();
    of.settings.shadows = true; // acts in the next frame
    of.configure();
    EXPECT_EQ(of.player.changes(), changes);
    of.settings.loudness = 0.5;
    of.configure();
    EXPECT_EQ(of.player.changes(), changes + 1);
    ASSERT_TRUE(of.plays());
    EXPECT_EQ(of.log->closed, 0) << "the device is open still";
    of.settings.dead = "1";
    of.configure();
    EXPECT_TRUE(eventually(
        [&]
        {
            of.frame();
            return of.log->closed > 0;
        }));
    EXPECT_TRUE(of.plays());
}

TEST(ScenePlayer, WhatChangesWhileItIsDisabledWaits)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    const std::uint64_t changes = of.player.changes();
    of.settings.enabled = false;
    of.settings.loudness = 0.5;
    of.configure();
    EXPECT_TRUE(eventually(
        [&]
        {
            of.frame();
            return of.player.state() == ArrayState::SILENT;
        }));
    EXPECT_EQ(of.player.changes(), changes);
    of.settings.enabled = true;
    of.configure();
    EXPECT_EQ(of.player.changes(), changes + 1);
    EXPECT_TRUE(of.plays());
}

TEST(ScenePlayer, TheStrictestCapHoldsWhoeverSetsIt)
{
    Played of;
    of.settings.maxPressure = 900.0;
    of.configure();
    of.player.refresh();
    EXPECT_EQ(of.player.playedSettings().maxPressure, 900.0);
    midair::device::UserCaps inner;
    inner.maxPressure_Pa = 700.0;
    inner.maxAmplitude = 0.5;
    of.player.setInnerLimits(inner);
    EXPECT_EQ(of.player.playedSettings().maxPressure, 700.0);
    {
        const SetVariable cap("OSG_MIDAIR_MAX_PRESSURE", "300");
        of.player.refresh();
        EXPECT_EQ(of.player.playedSettings().maxPressure, 300.0);
        EXPECT_EQ(of.player.playedSettings().maxAmplitude, 0.5);
        EXPECT_EQ(of.player.options().maxPressure, 300.0);
    }
    of.player.refresh();
    EXPECT_EQ(of.player.playedSettings().maxPressure, 700.0);
    EXPECT_EQ(of.player.settings().maxPressure, 900.0);
}

TEST(ScenePlayer, ACapThatIsNotUnderstoodSilencesAndIsTold)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    {
        const SetVariable cap("OSG_MIDAIR_MAX_AMPLITUDE", "much");
        of.player.refresh();
        EXPECT_FALSE(of.player.mayPlay());
        EXPECT_TRUE(of.says("OSG_MIDAIR_MAX_AMPLITUDE is \"much\""));
        EXPECT_TRUE(eventually(
            [&]
            {
                of.frame();
                return of.player.state() == ArrayState::SILENT;
            }));
    }
    EXPECT_TRUE(of.plays());
}

TEST(ScenePlayer, PlacesOfEarsThatAreTooManySilence)
{
    Played of;
    for (int i = 0; i < 64; ++i)
        of.settings.earPoints += "0 0 " + std::to_string(1 + i) + "; ";
    of.configure();
    EXPECT_TRUE(of.player.mayPlay());
    const SetVariable another("OSG_MIDAIR_EAR_POINTS", "0 1 0");
    of.player.refresh();
    EXPECT_FALSE(of.player.mayPlay());
    EXPECT_TRUE(of.says("earPoints is "));
}

TEST(ScenePlayer, MutedIsMutedBeforeThereIsADevice)
{
    Played of;
    of.player.setMuted(true);
    of.configure();
    EXPECT_TRUE(eventually(
        [&]
        {
            of.frame();
            return of.player.state() == ArrayState::MUTED;
        }));
    EXPECT_EQ(of.log->loudestAmplitude, 0.0F);
    of.player.setMuted(false);
    EXPECT_TRUE(of.plays());
}

TEST(ScenePlayer, StaysMutedWhenItsThreadEnds)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    of.player.setMuted(true);
    of.player.end().reset();
    EXPECT_TRUE(of.player.isMuted());
    of.log = std::make_shared<FakeLog>();
    of.configure();
    EXPECT_TRUE(eventually(
        [&]
        {
            of.frame();
            return of.player.state() == ArrayState::MUTED;
        }));
    EXPECT_EQ(of.log->loudestAmplitude, 0.0F);
    of.player.setMuted(false);
    EXPECT_TRUE(of.plays());
}

// It is destroyed later, and until then nobody leads it: its device's hold silences it.
TEST(ScenePlayer, AThreadThatHasEndedIsNotKeptAliveByTheFramesOfTheNextOne)
{
    Played of;
    of.player.setFilter(
        [&of](HologramOptions& options)
        {
            const HologramOptions fakes = fakeOptions(of.log);
            options.solverFactory = fakes.solverFactory;
            options.deviceFactory =
                [make = fakes.deviceFactory](const std::string& uri,
                                             const midair::device::DeviceLayout& layout)
            {
                midair::device::SafetyLimits limits;
                limits.hold_s = 0.3;
                return std::make_unique<midair::device::GuardedDevice>(
                    make(uri, layout), limits, layout.transducers);
            };
        });
    of.configure();
    ASSERT_TRUE(of.plays());
    const std::shared_ptr<FakeLog> before = of.log;
    const int silences = before->silences;
    const std::shared_ptr<void> ended = of.player.end();
    of.log = std::make_shared<FakeLog>();
    of.configure();
    EXPECT_TRUE(eventually(
        [&]
        {
            of.frame();
            return before->silences > silences;
        }));
    EXPECT_EQ(before->closed, 0);
}

TEST(ScenePlayer, ClosesAndOpensAgain)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    EXPECT_TRUE(of.player.close());
    EXPECT_TRUE(eventually(
        [&]
        {
            of.player.close();
            return of.player.isClosed();
        }));
    EXPECT_GT(of.log->closed, 0);
    EXPECT_NE(of.player.latestResult(), nullptr) << "that of the thread that has ended";
    of.configure();
    EXPECT_TRUE(of.plays());
    of.player.end().reset();
    EXPECT_TRUE(of.player.isClosed());
    EXPECT_EQ(of.player.state(), ArrayState::CLOSED);
}

TEST(ScenePlayer, KeptClosedItOpensNothing)
{
    Played of;
    of.player.keepClosed();
    of.configure();
    of.player.refresh();
    EXPECT_TRUE(of.player.isClosed());
    EXPECT_EQ(of.player.changes(), 1U);
    HologramOptions options = of.player.options();
    const HologramOptions fakes = fakeOptions(of.log);
    options.solverFactory = fakes.solverFactory;
    options.deviceFactory = fakes.deviceFactory;
    EXPECT_NE(of.player.pipelineMaker(options)(), nullptr);
    EXPECT_NE(of.player.array(), nullptr);
}

// Within the time for which frames follow each other once hands are gone.
TEST(SceneOptions, ContactsOfLostHandsGoOnForAsLongAsTheSettingSays)
{
    const SceneSettings defaults;
    const ContactRendererOptions before;
    EXPECT_EQ(optionsOf(defaults, 20.0).contacts.tracker.hold_s, before.tracker.hold_s);
    EXPECT_EQ(optionsOf(defaults, 20.0).contacts.shares.hold_s, before.shares.hold_s);
    for (const double hold_s : {0.0, 0.3})
    {
        SceneSettings settings;
        settings.contactHold = hold_s;
        const ContactRendererOptions contacts = optionsOf(settings, 20.0).contacts;
        EXPECT_EQ(contacts.tracker.hold_s, hold_s);
        EXPECT_EQ(contacts.shares.hold_s, hold_s);
        EXPECT_TRUE(contacts.isValid());
    }
}

namespace
{

/// Moves the square at 0.3 m/s in frames of 60 Hz whose light is seen 30 ms before they come.
/// Returns how far ahead of the last frame it is played.
double playedAhead_m(Played& of)
{
    constexpr int kFrames = 8;
    const double start_s =
        midair::base::steadySeconds() - kFrames / 60.0; // however slow the machine is
    double x_m = 0.0;
    for (int i = 0; i < kFrames; ++i)
    {
        x_m = 0.3 * i / 60.0;
        of.player.refresh();
        of.player.snapshot() = squareSnapshot(x_m);
        of.player.snapshot().time_s = start_s + i / 60.0;
        of.player.snapshot().simulationTime_s = i / 60.0;
        of.player.setDisplayTime(of.player.snapshot().time_s - 0.03);
        of.player.play(Eigen::Isometry3d::Identity());
        EXPECT_EQ(of.player.awaitField(60.0), "");
    }
    const std::lock_guard<std::mutex> lock(of.log->mutex);
    const auto x = of.log->points.positions.row(0); // those inside aren't symmetrical
    return 0.5 * (x.minCoeff() + x.maxCoeff()) - x_m;
}

} // namespace

TEST(ScenePlayer, MovingObjectsArePlayedWhereTheyAreSeenWhenTheSoundArrives)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    EXPECT_GT(playedAhead_m(of), 0.3 * 0.0305); // and the way through the air
    of.settings.extrapolate = false;
    of.configure();
    EXPECT_NEAR(playedAhead_m(of), 0.0, 1e-6);
}

TEST(ScenePlayer, WhatHasMovedIsHandedOverUntilItRests)
{
    Played of;
    of.configure();
    ASSERT_TRUE(of.plays());
    for (int i = 1; i < 5; ++i)
        EXPECT_TRUE(of.frame(0.001 * i));
    EXPECT_TRUE(of.frame(0.004)) << "it isn't known to rest yet";
    EXPECT_TRUE(eventually([&] { return !of.frame(0.004); }));
    of.settings.extrapolate = false;
    of.configure();
    for (int i = 1; i < 5; ++i)
        EXPECT_TRUE(of.frame(0.001 * i));
    EXPECT_FALSE(of.frame(0.004));
}
