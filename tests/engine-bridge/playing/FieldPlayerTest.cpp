#include "engine-bridge/playing/FieldPlayer.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/InputError.h"
#include "tests/engine-bridge/playing/PlayerDevices.h"

#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

namespace
{

using midair::bridge::FieldPlayer;
using midair::device::DriveSignal;

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
    DriveSignal full;
    midair::device::encode(q.data(), 3, full);
    player.play({full}, options);
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
    const auto failing = [&](const std::vector<DriveSignal>& cycle)
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
    std::vector<DriveSignal> fields = numberedFields(2);
    fields[1].phase.resize(4);
    fields[1].duty.resize(4);
    EXPECT_EQ(failing(fields), "field player: field 1 is for 4 transducers, the first one for 5");
    fields = numberedFields(2);
    fields[1].duty.resize(3);
    EXPECT_EQ(failing(fields), "field player: field 1 is for 5 transducers, the first one for 5");
    EXPECT_TRUE(device.signals().empty());
    player.play(numberedFields(1));
    EXPECT_TRUE(device.waitFor(1));
}

} // namespace
