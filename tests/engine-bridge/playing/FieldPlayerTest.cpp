#include "engine-bridge/playing/FieldPlayer.h"

#include "device/DriveEncoder.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/device/TestFiles.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

namespace
{

using midair::bridge::FieldPlayer;
using midair::device::DriveSignal;

/// Keeps what it is sent.
class Collector : public midair::device::ArrayDevice
{
public:
    bool send(const DriveSignal& signal) override
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _signals.push_back(signal);
        return !refusing;
    }
    void silence() override {}
    std::string status() const override { return "collects"; }
    midair::device::DeviceReport report() const override { return {}; }
    std::vector<std::complex<float>> played() const override { return {}; }

    std::vector<DriveSignal> signals() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _signals;
    }
    /// Until \a count signals are there; false after ten seconds, far beyond what a busy machine needs.
    bool waitFor(std::size_t count) const
    {
        for (int k = 0; k < 10000 && signals().size() < count; ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return signals().size() >= count;
    }

    std::atomic<bool> refusing{false};

private:
    mutable std::mutex _mutex;
    std::vector<DriveSignal> _signals;
};

/// One that keeps sequences of up to four fields, and the times at which they came.
class Keeper : public Collector
{
public:
    struct Kept
    {
        midair::device::DriveSequence sequence;
        double time_s = 0;
    };
    bool sendSequence(const midair::device::DriveSequence& sequence) override
    {
        const std::lock_guard<std::mutex> lock(_keeping);
        _kept.push_back({sequence, midair::base::steadySeconds()});
        return !refusing;
    }
    midair::device::DriveAbility ability() const override
    {
        midair::device::DriveAbility ability;
        ability.sequenceFields = 4;
        return ability;
    }
    std::vector<Kept> kept() const
    {
        const std::lock_guard<std::mutex> lock(_keeping);
        return _kept;
    }
    bool waitForSequences(std::size_t count) const
    {
        for (int k = 0; k < 10000 && kept().size() < count; ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return kept().size() >= count;
    }

private:
    mutable std::mutex _keeping;
    std::vector<Kept> _kept;
};

// Field k has all phases at level 10 k, and full amplitude.
std::vector<Eigen::VectorXcf> numberedFields(int count)
{
    std::vector<Eigen::VectorXcf> fields;
    for (int k = 0; k < count; ++k)
        fields.emplace_back(Eigen::VectorXcf::Constant(
            5, std::polar(1.0f, static_cast<float>(2.0 * M_PI * 10 * k / 256.0))));
    return fields;
}

TEST(FieldPlayer, PlaysTheFieldsInTurn)
{
    Collector device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(4), options);
    ASSERT_TRUE(device.waitFor(20));
    player.stop();
    const std::vector<DriveSignal> signals = device.signals();
    const FieldPlayer::Counters counters = player.counters();
    EXPECT_EQ(counters.sent, signals.size());
    // Each is one on from the one before; with steps left out on a busy machine, more.
    std::uint64_t ahead = signals[0].phase[0] / 10;
    for (std::size_t k = 1; k < signals.size(); ++k)
    {
        ASSERT_EQ(signals[k].phase[0] % 10, 0);
        ASSERT_EQ(signals[k].duty[0], 255);
        ahead += static_cast<std::uint64_t>(
            (signals[k].phase[0] / 10 - signals[k - 1].phase[0] / 10 + 4) % 4);
    }
    EXPECT_EQ((ahead + counters.leftOut * 3) % 4, (signals.size() - 1) % 4);
    // After stop() nothing comes any more.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(device.signals().size(), signals.size());
}

TEST(FieldPlayer, ASingleFieldIsSentOnce)
{
    Collector device;
    FieldPlayer player(device);
    player.play(numberedFields(1));
    ASSERT_TRUE(device.waitFor(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(device.signals().size(), 1u);
    player.play(numberedFields(1));
    EXPECT_TRUE(device.waitFor(2));
}

TEST(FieldPlayer, OneThatIsRefusedIsSentAgain)
{
    Collector device;
    device.refusing = true;
    FieldPlayer player(device);
    player.play(numberedFields(1));
    ASSERT_TRUE(device.waitFor(3));
    device.refusing = false;
    for (int k = 0; k < 10000 && player.counters().sent == 0; ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(player.counters().sent, 1u);
    EXPECT_GE(player.counters().refused, 3u);
}

TEST(FieldPlayer, TheAmplitudeIsModulatedWithinALevelOfWhatEncodingGives)
{
    Collector device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 1000.0;
    options.amplitudeRate_Hz = 250.0; // amplitudes 1, sqrt(1/2), 0, sqrt(1/2)
    Eigen::VectorXcf q(3);
    q << 1.0f, 0.5f, 0.1f;
    player.play({q}, options);
    ASSERT_TRUE(device.waitFor(40));
    player.stop();
    int seen[3] = {0, 0, 0};
    for (const DriveSignal& signal : device.signals())
    {
        int matches = -1;
        int k = 0;
        for (const float amplitude : {1.0f, std::sqrt(0.5f), 0.0f})
        {
            const Eigen::VectorXcf scaled = q * amplitude;
            DriveSignal expected;
            midair::device::encode(scaled.data(), 3, expected);
            bool all = true;
            // Rounded twice, to the level of q and then to that of the product.
            for (int i = 0; i < 3; ++i)
                all = all && std::abs(signal.duty[i] - expected.duty[i]) <= 1;
            if (all) matches = k;
            ++k;
        }
        ASSERT_GE(matches, 0);
        ++seen[matches];
    }
    for (const int times : seen)
        EXPECT_GT(times, 0);
}

TEST(FieldPlayer, SaysWhatIsWrongAndGoesOn)
{
    Collector device;
    FieldPlayer player(device);
    const auto failing = [&](const std::vector<Eigen::VectorXcf>& cycle)
    {
        try
        {
            player.play(cycle);
        }
        catch (const midair::base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(failing({}), "field player: there are no fields; there must be at least one");
    std::vector<Eigen::VectorXcf> fields = numberedFields(2);
    fields[1].conservativeResize(4);
    EXPECT_EQ(failing(fields), "field player: field 1 has 4 activations, the first one 5");
    fields = numberedFields(2);
    fields[1][3] = std::nanf("");
    EXPECT_EQ(failing(fields), "field player: field 1 has an activation that is not finite");
    EXPECT_TRUE(device.signals().empty());
    player.play(numberedFields(1));
    EXPECT_TRUE(device.waitFor(1));
}

TEST(FieldPlayer, ADeviceThatKeepsSequencesIsSentOneWhole)
{
    Keeper device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 500.0;
    player.play(numberedFields(4), options);
    ASSERT_TRUE(device.waitForSequences(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ASSERT_EQ(device.kept().size(), 1u);
    EXPECT_TRUE(device.signals().empty());
    const midair::device::DriveSequence sequence = device.kept()[0].sequence;
    EXPECT_EQ(sequence.rate_Hz, 500.0);
    ASSERT_EQ(sequence.signals.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k)
        EXPECT_EQ(sequence.signals[k].phase[0], 10 * k);
    EXPECT_EQ(player.counters().sent, 1u);
    // A single field is a field.
    player.play(numberedFields(1), options);
    ASSERT_TRUE(device.waitFor(1));
    EXPECT_EQ(device.kept().size(), 1u);
}

TEST(FieldPlayer, ASequenceGoesOnInTheTimeOfTheOneBefore)
{
    Keeper device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    options.fieldRate_Hz = 20.0;
    player.play(numberedFields(4), options);
    ASSERT_TRUE(device.waitForSequences(1));
    for (std::size_t k = 1; k < 4; ++k)
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(70));
        player.play(numberedFields(4), options);
        ASSERT_TRUE(device.waitForSequences(k + 1));
    }
    const FieldPlayer::Counters counters = player.counters();
    if (counters.worstLateness_s > 0.02) GTEST_SKIP() << "the machine is too busy to tell steps";
    EXPECT_EQ(counters.leftOut, 0u); // the device played those in between
    const std::vector<Keeper::Kept> kept = device.kept();
    for (const Keeper::Kept& one : kept)
    {
        const double steps = (one.time_s - kept[0].time_s) * options.fieldRate_Hz;
        EXPECT_NEAR(steps, std::round(steps), 0.45);
        const auto first = static_cast<unsigned>(std::lround(steps)) % 4;
        for (unsigned k = 0; k < 4; ++k)
            EXPECT_EQ(one.sequence.signals[k].phase[0], 10 * ((first + k) % 4));
    }
}

TEST(FieldPlayer, WhatADeviceCanNotKeepIsSentStepByStep)
{
    Keeper device;
    FieldPlayer player(device);
    midair::haptics::ModulatorOptions options;
    player.play(numberedFields(5), options); // it keeps four
    ASSERT_TRUE(device.waitFor(10));
    options.amplitudeRate_Hz = 300.0; // 3 1/3 steps
    player.play(numberedFields(1), options);
    ASSERT_TRUE(device.waitFor(device.signals().size() + 10));
    EXPECT_TRUE(device.kept().empty());
    options.amplitudeRate_Hz = 250.0;
    player.play(numberedFields(1), options);
    ASSERT_TRUE(device.waitForSequences(1));
    player.stop();
    const std::size_t steps = device.signals().size();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(device.signals().size(), steps);
    EXPECT_EQ(device.kept().size(), 1u);
}

TEST(FieldPlayer, ASequenceThatIsRefusedIsSentAgain)
{
    Keeper device;
    device.refusing = true;
    FieldPlayer player(device);
    player.play(numberedFields(4));
    ASSERT_TRUE(device.waitForSequences(3));
    device.refusing = false;
    for (int k = 0; k < 10000 && player.counters().sent == 0; ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(player.counters().sent, 1u);
    EXPECT_GE(player.counters().refused, 3u);
    EXPECT_TRUE(device.signals().empty());
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
    const auto play = [&](midair::device::ArrayDevice& device)
    {
        FieldPlayer player(device);
        player.play(numberedFields(3), options);
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        player.stop();
        device.silence();
        return player.counters();
    };
    const std::string whole = temporaryFile("whole");
    const std::string steps = temporaryFile("steps");
    EXPECT_EQ(play(*openDevice("record:" + whole, {5, {}})).sent, 1u);
    StepsOnly stepsOnly(openDevice("record:" + steps, {5, {}}));
    const FieldPlayer::Counters counters = play(stepsOnly);
    EXPECT_GT(counters.sent, 10u);
    const auto kept = entriesOf(whole);
    const auto sent = entriesOf(steps);
    ASSERT_GT(kept.size(), 25u);
    // Steps of the thread are late at times, or left out; their times say which they are.
    for (std::size_t k = 0; k + 1 < sent.size(); ++k)
    {
        const double step =
            static_cast<double>(sent[k].time_ns - sent[0].time_ns) * 1e-9 * options.fieldRate_Hz;
        const auto same = static_cast<std::size_t>(std::lround(step)) % 12; // of both periods
        if (counters.worstLateness_s * options.fieldRate_Hz < 0.4)
        {
            EXPECT_EQ(sent[k].signal.phase, kept[same].signal.phase) << k;
            EXPECT_EQ(sent[k].signal.duty, kept[same].signal.duty) << k;
        }
        else
            EXPECT_TRUE(std::any_of(kept.begin(),
                                    kept.begin() + 12,
                                    [&](const auto& entry)
                                    {
                                        return entry.signal.phase == sent[k].signal.phase &&
                                               entry.signal.duty == sent[k].signal.duty;
                                    }));
    }
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
        EXPECT_EQ(kept[k].time_ns - kept[0].time_ns, 5'000'000 * k);
}

} // namespace
