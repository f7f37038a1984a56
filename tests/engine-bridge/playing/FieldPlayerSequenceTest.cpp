// What a player does on a device that keeps sequences and times them by itself.
#include "engine-bridge/playing/FieldPlayer.h"
#include "tests/Eventually.h"
#include "tests/device/TestFiles.h"
#include "tests/engine-bridge/playing/PlayerDevices.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace
{

using midair::bridge::FieldPlayer;
using midair::device::DriveSignal;
using midair::test::SetClock;

TEST(FieldPlayer, ADeviceThatKeepsSequencesIsSentOneWhole)
{
    SetClock clock;
    Keeper device(clock);
    FieldPlayer player(device, clock);
    clock.await(1);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(4), options);
    clock.pass(1.0);
    ASSERT_EQ(device.kept().size(), 1u);
    EXPECT_TRUE(device.signals().empty());
    const midair::device::DriveSequence sequence = device.kept()[0].sequence;
    EXPECT_EQ(sequence.rate_Hz, 500.0);
    ASSERT_EQ(sequence.signals.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k)
        EXPECT_EQ(sequence.signals[k].phase[0], 10 * k);
    EXPECT_EQ(player.counters().sent, 1u);
    EXPECT_EQ(player.counters().leftOut, 0u);
    // A single field is a field.
    player.play(numberedFields(1), options);
    clock.pass(1.0);
    EXPECT_EQ(device.signals().size(), 1u);
    EXPECT_EQ(device.kept().size(), 1u);
}

TEST(FieldPlayer, ASequenceGoesOnInTheTimeOfTheOneBefore)
{
    SetClock clock;
    Keeper device(clock);
    FieldPlayer player(device, clock);
    clock.await(1);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 20.0;
    player.play(numberedFields(4), options);
    for (std::size_t k = 1; k < 4; ++k)
    {
        clock.pass(0.07);
        player.play(numberedFields(4), options);
    }
    clock.pass(0.07);
    EXPECT_EQ(player.counters().leftOut, 0u); // the device played those in between
    const std::vector<Keeper::Kept> kept = device.kept();
    ASSERT_EQ(kept.size(), 4u);
    for (const Keeper::Kept& one : kept)
    {
        const double steps = (one.time_s - kept[0].time_s) * options.fieldRate_Hz;
        EXPECT_NEAR(steps, std::round(steps), 1e-6);
        const auto first = static_cast<unsigned>(std::lround(steps)) % 4;
        for (unsigned k = 0; k < 4; ++k)
            EXPECT_EQ(one.sequence.signals[k].phase[0], 10 * ((first + k) % 4));
    }
}

TEST(FieldPlayer, WhatADeviceCanNotKeepIsSentStepByStep)
{
    SetClock clock;
    Keeper device(clock);
    FieldPlayer player(device, clock);
    clock.await(1);
    midair::haptics::ModulatorOptions options;
    player.play(numberedFields(5), options); // it keeps four
    clock.pass(0.02);
    const std::size_t before = device.signals().size();
    EXPECT_GE(before, 10u);
    options.amplitudeRate_Hz = 300.0; // 3 1/3 steps
    player.play(numberedFields(1), options);
    clock.pass(0.02);
    EXPECT_GE(device.signals().size(), before + 10);
    EXPECT_TRUE(device.kept().empty());
    options.amplitudeRate_Hz = 250.0;
    player.play(numberedFields(1), options);
    clock.pass(0.02);
    EXPECT_EQ(device.kept().size(), 1u);
    player.stop();
    const std::size_t steps = device.signals().size();
    clock.pass(0.02);
    EXPECT_EQ(device.signals().size(), steps);
    EXPECT_EQ(device.kept().size(), 1u);
}

TEST(FieldPlayer, ASequenceAtARateThatADevicesClockHasNotIsSentStepByStep)
{
    Keeper device;
    device.clock_Hz = 40e3;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 300.0;
    player.play(numberedFields(4), options);
    ASSERT_TRUE(device.waitFor(10));
    EXPECT_TRUE(device.kept().empty());
    options.fieldRate_Hz = 40e3 / 3;
    player.play(numberedFields(4), options);
    ASSERT_TRUE(device.waitForSequences(1));
}

TEST(FieldPlayer, ASequenceThatIsRefusedIsSentAgain)
{
    SetClock clock;
    Keeper device(clock);
    device.refusing = true;
    FieldPlayer player(device, clock);
    clock.await(1);
    player.play(numberedFields(4));
    clock.pass(0.05);
    const std::uint64_t refused = player.counters().refused;
    EXPECT_GE(refused, 3u);
    EXPECT_LE(refused, 4u) << "not at every step";
    device.refusing = false;
    clock.pass(0.1);
    EXPECT_EQ(player.counters().sent, 1u);
    EXPECT_EQ(player.counters().refused, refused);
    EXPECT_TRUE(device.signals().empty());
}

/// Refuses sequences, and has a line that carries so many fields a second.
class Refuser : public Keeper
{
public:
    bool sendSequence(const midair::device::DriveSequence& sequence) override
    {
        Keeper::sendSequence(sequence);
        return false;
    }
    midair::device::DriveAbility ability() const override
    {
        midair::device::DriveAbility ability = Keeper::ability();
        ability.fieldsPerSecond = 60.0;
        return ability;
    }
};

TEST(FieldPlayer, ASequenceThatADeviceCanNotTimeIsSentStepByStepIfItsLineCarriesThat)
{
    Refuser device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 50.0;
    player.play(numberedFields(4), options);
    EXPECT_TRUE(device.waitFor(8));
    EXPECT_EQ(device.kept().size(), 1U);
    EXPECT_EQ(player.counters().streamed, "it refuses them");

    Refuser slow;
    FieldPlayer other(slow);
    options.fieldRate_Hz = 100.0;
    other.play(numberedFields(4), options);
    EXPECT_TRUE(slow.waitForSequences(3)) << "it is asked again";
    EXPECT_TRUE(slow.signals().empty()) << "which would be another modulation";
}

TEST(FieldPlayer, ASequenceIsSentAgainWhenTheDeviceWasSilenced)
{
    const std::string file = temporaryFile("fields");
    const auto device = midair::device::openDevice("record:" + file, {5, {}});
    SetClock clock;
    FieldPlayer player(*device, clock);
    clock.await(1);
    player.play(numberedFields(4));
    clock.pass(0.2);
    ASSERT_EQ(player.counters().sent, 1u);
    device->silence();
    clock.pass(0.06);
    EXPECT_EQ(player.counters().sent, 2u);
    device->setMuted(true);
    clock.pass(0.12);
    EXPECT_GE(player.counters().refused, 2u);
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(5));
    device->setMuted(false);
    clock.pass(0.06);
    EXPECT_EQ(player.counters().sent, 3u);
    EXPECT_NE(device->played(), std::vector<std::complex<float>>(5));
    clock.pass(1.0);
    EXPECT_EQ(player.counters().sent, 3u) << "what plays undisturbed is left alone";
}

/// A recording that is taken for a device that keeps no sequences.
class StepsOnly : public midair::device::ArrayDevice
{
public:
    explicit StepsOnly(std::unique_ptr<ArrayDevice> device) : _device(std::move(device)) {}
    bool send(const DriveSignal& signal) override { return _device->send(signal); }
    void silence() override { _device->silence(); }
    std::string status() const override { return _device->status(); }
    midair::device::DeviceReport report() const override { return _device->report(); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }

private:
    std::unique_ptr<ArrayDevice> _device;
};

TEST(FieldPlayer, ARecordingHasTheSameFieldsHoweverItIsPlayed)
{
    using midair::device::openDevice;
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 200.0;
    options.amplitudeRate_Hz = 50.0;
    const auto play = [&](midair::device::ArrayDevice& device, const std::string& file)
    {
        FieldPlayer player(device);
        player.play(numberedFields(3), options);
        EXPECT_TRUE(eventually([&] { return entriesOf(file).size() > 26; }));
        player.stop();
        device.silence();
        return player.counters();
    };
    const std::string whole = temporaryFile("whole");
    const std::string steps = temporaryFile("steps");
    EXPECT_EQ(play(*openDevice("record:" + whole, {5, {}}), whole).sent, 1u);
    StepsOnly stepsOnly(openDevice("record:" + steps, {5, {}}));
    const FieldPlayer::Counters counters = play(stepsOnly, steps);
    EXPECT_GT(counters.sent, 10u);
    const auto kept = entriesOf(whole);
    const auto sent = entriesOf(steps);
    ASSERT_GT(kept.size(), 25u);
    // Steps of the thread are late at times, or left out, the first ones too; their times say which
    // they are.
    const auto stepOf = [&](std::size_t k)
    {
        return std::lround(static_cast<double>(sent[k].time_ns - sent[0].time_ns) * 1e-9 *
                           options.fieldRate_Hz);
    };
    const auto isSame = [&](std::size_t k, std::size_t other)
    {
        return sent[k].signal.phase == kept[other].signal.phase &&
               sent[k].signal.duty == kept[other].signal.duty;
    };
    constexpr std::size_t kPeriod = 12; // of fields and amplitudes
    const bool isOnTime = counters.worstLateness_s * options.fieldRate_Hz < 0.4;
    bool isAny = false;
    for (std::size_t first = 0; first < kPeriod; ++first)
    {
        bool isAll = true;
        for (std::size_t k = 0; k + 1 < sent.size(); ++k)
            isAll = isAll && isSame(k, (first + static_cast<std::size_t>(stepOf(k))) % kPeriod);
        isAny = isAny || isAll;
    }
    EXPECT_TRUE(isAny || !isOnTime);
    for (std::size_t k = 0; k + 1 < sent.size(); ++k)
    {
        bool isKept = false;
        for (std::size_t other = 0; other < kPeriod; ++other)
            isKept = isKept || isSame(k, other);
        EXPECT_TRUE(isKept) << k;
    }
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
        EXPECT_EQ(kept[k].time_ns - kept[0].time_ns, 5'000'000 * k);
}

TEST(FieldPlayer, TellsWhyADeviceThatTimesSequencesGetsFieldsOneByOne)
{
    Keeper device;
    device.clock_Hz = 40000;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(4), options);
    EXPECT_EQ(player.counters().streamed, "");
    options.fieldRate_Hz = 300.0;
    player.play(numberedFields(4), options);
    EXPECT_EQ(player.counters().streamed, "300 fields/s aren't 40000 Hz over a whole number");
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(5), options);
    EXPECT_EQ(player.counters().streamed, "it doesn't repeat within 4 steps");
    player.play(numberedFields(4), options);
    EXPECT_EQ(player.counters().streamed, "");
}

} // namespace
