#include "haptics/sensation/SensationPlayer.h"

#include "haptics/base/Units.h"
#include "tests/haptics/sensation/Patterns.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;
using namespace patterns;

namespace
{

/// A loop of 60 ms at a speed of its own, with a stop behind the jump.
Json loop(double speed)
{
    Json json =
        pattern({standard(0.0, coords(0, 0, 0)), standard(60.0, coords(60, 0, 0)), stop(60.0)});
    json["keyframes"][0]["intensity"] = intensity(number(1.0));
    json["keyframes"][1]["cjumps"] = Json::array({jump("p", "lt", 1.0, 0.0)});
    define(json, "p", {{"default", 0.0}});
    json["pattern_transform"]["playback_speed"] = number(speed);
    return json;
}

/// A circle whose frequencies are parameters.
Json tone()
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    json["keyframes"][0]["brush"] = circle(number(10.0), parameter("draw"), parameter("am"));
    json["keyframes"][0]["intensity"] = intensity(number(1.0));
    define(json, "draw", {{"default", 70.0}});
    define(json, "am", {{"default", 30.0}});
    return json;
}

double angleOf(const SensationSample& sample)
{
    return std::atan2(sample.position_mm.y(), sample.position_mm.x());
}

} // namespace

TEST(SensationPlayer, LoopsTakeAsLongAtEachRateOfFields)
{
    for (const double speed : {1.0, 0.9, 2.7})
        for (const double interval_ms : {0.05, 0.3, 1.0, 11.3, 70.0})
        {
            SensationPlayer player(read(loop(speed)));
            // A loop takes 60 ms/speed, up to the next multiple of 0.05 ms.
            const double loop_ms = std::ceil(60.0 / speed * 20.0 - 1e-6) / 20.0;
            for (int k = 0; k * interval_ms < 1000.0; ++k)
            {
                const double time_ms = k * interval_ms;
                const SensationSample sample = player.sampleAt(time_ms);
                ASSERT_FALSE(sample.isStopped) << speed << " " << interval_ms << " " << time_ms;
                const double in_ms = std::fmod(time_ms, loop_ms);
                if (k > 0 && std::min(in_ms, loop_ms - in_ms) < 1e-6) continue; // by rounding
                ASSERT_NEAR(sample.patternTime_ms, std::min(60.0, speed * in_ms), 1e-6)
                    << speed << " " << interval_ms << " " << time_ms;
            }
        }
}

TEST(SensationPlayer, ReachesTheStopWhenNoJumpHolds)
{
    SensationPlayer player(read(loop(1.0)));
    EXPECT_TRUE(player.values().set("p", 1.0));
    EXPECT_EQ(player.sampleAt(59.99).intensity, 1.0);
    const SensationSample stopped = player.sampleAt(60.0);
    EXPECT_TRUE(stopped.isStopped);
    EXPECT_EQ(stopped.intensity, 0.0);
    player.restart();
    EXPECT_FALSE(player.sampleAt(1.0).isStopped);
}

TEST(SensationPlayer, KeepsFrequenciesOverTenSeconds)
{
    SensationPlayer player(read(tone()));
    for (int k = 0; k <= 10000; ++k)
    {
        const SensationSample sample = player.sampleAt(k);
        const double turns = 70.0 * k * 1e-3;
        ASSERT_NEAR(sample.position_mm.x(), 10.0 * std::cos(midair::base::kTwoPi * turns), 1e-6);
        ASSERT_NEAR(
            sample.intensity, 0.5 + 0.5 * std::cos(midair::base::kTwoPi * 30.0 * k * 1e-3), 1e-7);
    }
}

TEST(SensationPlayer, ChangesFrequenciesWithoutAJump)
{
    SensationPlayer player(read(tone()));
    for (int k = 0; k <= 333; ++k)
        player.sampleAt(k);
    const SensationSample before = player.sampleAt(333.0);
    player.values().set("draw", 110.0);
    player.values().set("am", 47.0);
    const SensationSample same = player.sampleAt(333.0);
    EXPECT_NEAR(angleOf(same), angleOf(before), 1e-12);
    EXPECT_NEAR(same.intensity, before.intensity, 1e-12);
    const double turned = angleOf(player.sampleAt(334.0)) - angleOf(same);
    EXPECT_NEAR(
        std::remainder(turned - midair::base::kTwoPi * 0.11, midair::base::kTwoPi), 0.0, 1e-9);
}

TEST(SensationPlayer, IntegratesAFrequencyThatChangesBetweenKeyframes)
{
    // From 0 to 100 Hz within 100 ms, which are 5 periods, then 100 Hz.
    Json json = pattern({standard(0.0, coords(0, 0, 0)), standard(100.0, coords(0, 0, 0))});
    json["keyframes"][0]["brush"] = circle(number(1.0), number(0.0), number(0.0));
    json["keyframes"][1]["brush"] = circle(number(1.0), number(0.0), number(100.0));
    json["keyframes"][0]["intensity"] = intensity(number(1.0));
    for (const double interval_ms : {0.5, 7.0, 130.0})
    {
        SensationPlayer player(read(json));
        for (double time_ms = 0.0; time_ms < 300.0; time_ms += interval_ms)
        {
            const double early_s = 1e-3 * std::min(time_ms, 100.0);
            const double periods = 500.0 * early_s * early_s + 0.1 * std::max(0.0, time_ms - 100.0);
            ASSERT_NEAR(player.sampleAt(time_ms).intensity,
                        0.5 + 0.5 * std::cos(midair::base::kTwoPi * periods),
                        1e-9)
                << interval_ms << " " << time_ms;
        }
    }
}

TEST(SensationPlayer, HoldsRandomIntensitiesAndRepeatsThemWithTheSeed)
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    json["keyframes"][0]["intensity"] = intensity(number(0.0));
    json["keyframes"][0]["intensity"]["intensity"] =
        variant("random", {{"min", number(0.0)}, {"max", number(1.0)}});
    const auto sensation = read(json);
    SensationPlayerOptions other;
    other.seed = 2;
    SensationPlayer first(sensation), second(sensation), third(sensation, other);
    int changes = 0, differs = 0;
    double last = first.sampleAt(0.0).intensity;
    for (int k = 1; k < 1000; ++k)
    {
        const double value = first.sampleAt(k).intensity;
        if (value != last)
        {
            EXPECT_EQ(k % 5, 0);
            ++changes;
        }
        last = value;
        EXPECT_EQ(second.sampleAt(k).intensity, value);
        differs += third.sampleAt(k).intensity != value ? 1 : 0;
    }
    EXPECT_EQ(changes, 199);
    EXPECT_GT(differs, 900);
}

TEST(SensationPlayer, LimitsIntensitiesAndSilencesWhatIsNotFinite)
{
    Json json = tone();
    json["keyframes"][0]["intensity"] = intensity(parameter("strength"));
    json["pattern_transform"]["geometric_transforms"]["scale"]["x"] = parameter("size");
    define(json, "strength", {{"default", 3.0}});
    const Json zero = {{"type", "constant"}, {"value", 0.0}};
    const Json size = {{"type", "parameter"}, {"value", "size"}};
    json["pattern_transform"]["geometric_transforms"]["translate"]["x"] = {
        {"type", "formula"}, {"value", {{"type", "divide"}, {"value", Json::array({zero, size})}}}};
    define(json, "size", {{"default", 1.0}});
    SensationPlayer player(read(json));
    const SensationSample loud = player.sampleAt(0.0);
    EXPECT_EQ(loud.intensity, 1.0);
    EXPECT_TRUE(loud.isLimited);
    player.values().set("size", 0.0); // 0/0
    const SensationSample broken = player.sampleAt(1.0);
    EXPECT_FALSE(broken.isFinite);
    EXPECT_EQ(broken.intensity, 0.0);
    EXPECT_EQ(broken.position_mm, loud.position_mm);
    player.values().set("size", 1.0);
    EXPECT_TRUE(player.sampleAt(2.0).isFinite);
}

TEST(SensationPlayer, GoesOnAfterASpeedThatIsNotFinite)
{
    Json json = loop(1.0);
    const Json one = {{"type", "constant"}, {"value", 1.0}};
    const Json slow = {{"type", "parameter"}, {"value", "slow"}};
    json["pattern_transform"]["playback_speed"] = {
        {"type", "formula"}, {"value", {{"type", "divide"}, {"value", Json::array({one, slow})}}}};
    define(json, "slow", {{"default", 1.0}});
    SensationPlayer player(read(json));
    EXPECT_EQ(player.sampleAt(10.0).patternTime_ms, 10.0);
    player.values().set("slow", 0.0);
    EXPECT_EQ(player.sampleAt(20.0).intensity, 0.0);
    player.values().set("slow", 2.0);
    EXPECT_DOUBLE_EQ(player.sampleAt(30.0).patternTime_ms, 15.0);
}

TEST(SensationPlayer, DropsTheHeightOfTheArraysFrame)
{
    Json json = tone();
    json["keyframes"][0]["coords"]["coords"]["z"] = 3.0;
    json["pattern_transform"]["geometric_transforms"]["translate"]["z"] = number(200.0);
    SensationPlayerOptions options;
    EXPECT_EQ(SensationPlayer(read(json), options).sampleAt(0.0).position_mm.z(), 203.0);
    options.dropsHeight = true;
    EXPECT_EQ(SensationPlayer(read(json), options).sampleAt(0.0).position_mm.z(), 3.0);
}

TEST(SensationPlayer, ReplacesAPatternAtItsTime)
{
    SensationPlayer player(read(loop(1.0)));
    player.values().set("p", 0.5);
    player.sampleAt(20.0);
    Json json = loop(2.0);
    json["keyframes"][1]["coords"]["coords"]["x"] = 600.0;
    player.replace(read(json));
    const SensationSample sample = player.sampleAt(21.0);
    EXPECT_DOUBLE_EQ(sample.patternTime_ms, 22.0);
    EXPECT_DOUBLE_EQ(sample.position_mm.x(), 220.0);
    EXPECT_EQ(player.values()[0], 0.5);
}

TEST(SensationPlayer, EndsAtOnceWhateverATimeOrALoopIs)
{
    // A loop of no length, and a loop that is far shorter than a step.
    for (const double to_ms : {60.0, 60.0 - 1e-9})
    {
        Json json = loop(1.0);
        json["keyframes"][1]["cjumps"][0]["jump_to"] = to_ms;
        SensationPlayer player(read(json));
        for (const double time_ms : {61.0, 1e6, 1e300, -1.0, std::nan("")})
            EXPECT_TRUE(player.sampleAt(time_ms).position_mm.allFinite()) << time_ms;
    }
}
