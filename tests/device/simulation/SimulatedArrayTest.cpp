#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"

#include <chrono>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

bool silent(const ArrayDevice& device)
{
    for (const std::complex<float> q : device.played())
        if (std::abs(q) > 0) return false;
    return true;
}

DeviceLayout boards(int transducers, int perBoard)
{
    DeviceLayout layout{transducers, {}};
    for (int i = 0; i < transducers; ++i)
        layout.board.push_back(i / perBoard);
    return layout;
}

} // namespace

TEST(SimulatedArray, holds_a_field_while_nothing_is_sent)
{
    const auto device = openDevice("sim:", {4, {}});
    ASSERT_TRUE(device->send(evenField(4, 1, 200)));
    letPass(0.25); // longer than the watchdog
    EXPECT_FALSE(silent(*device));
}

TEST(SimulatedArray, loses_packets_but_never_plays_a_mixture)
{
    const auto device = openDevice("sim:?drop=0.05&seed=3", boards(400, 40));
    int kept = 0;
    for (int i = 1; i <= 200; ++i)
    {
        ASSERT_TRUE(device->send(evenField(400, static_cast<std::uint8_t>(i), 255)));
        const auto q = device->played();
        EXPECT_EQ(q, std::vector<std::complex<float>>(400, q[0]));
        kept += std::abs(q[0] - std::polar(1.0F, static_cast<float>(2 * M_PI * i / 256))) < 1e-3F
                    ? 1
                    : 0;
    }
    // All of 11 packets arrive with 0.95^11 = 0.57: 114 of 200, give or take 4 deviations of 7.
    EXPECT_NEAR(kept, 114, 28);
    const DeviceReport report = device->report();
    EXPECT_EQ(report.played, static_cast<std::uint64_t>(kept));
    EXPECT_EQ(report.sent, report.played + report.lost);
    EXPECT_NE(device->status().find("incomplete"), std::string::npos) << device->status();
}

TEST(SimulatedArray, notices_corrupted_packets)
{
    const auto device = openDevice("sim:?corrupt=0.3&seed=5", boards(40, 20));
    for (int i = 1; i <= 100; ++i)
    {
        device->send(evenField(40, static_cast<std::uint8_t>(i), 255));
        const auto q = device->played();
        EXPECT_EQ(q, std::vector<std::complex<float>>(40, q[0]));
    }
    EXPECT_GT(device->report().lost, 0U);
    EXPECT_GT(device->report().played, 0U);
}

TEST(SimulatedArray, can_be_unplugged)
{
    const auto device = openDevice("sim:?unplug_at=100ms", {4, {}});
    ASSERT_TRUE(device->send(evenField(4, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::LOST; }));
    EXPECT_EQ(device->report().message, "unplugged");
    EXPECT_TRUE(silent(*device));
    EXPECT_FALSE(device->send(evenField(4, 1, 200)));
    EXPECT_EQ(device->report().reconnects, 0U);
}

TEST(SimulatedArray, can_be_plugged_in_again)
{
    const auto device = openDevice("sim:?unplug_at=100ms&replug_at=200ms", {4, {}});
    ASSERT_TRUE(device->send(evenField(4, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().reconnects == 1; }));
    EXPECT_EQ(device->report().state, DeviceState::READY);
    EXPECT_TRUE(silent(*device)); // until the next field
    ASSERT_TRUE(device->send(evenField(4, 1, 200)));
    EXPECT_FALSE(silent(*device));
}

TEST(SimulatedArray, is_muted_by_its_watchdog_when_the_host_hangs)
{
    const auto device = openDevice("sim:?hang_at=500ms", {4, {}});
    ASSERT_TRUE(device->send(evenField(4, 1, 200)));
    EXPECT_FALSE(silent(*device));
    EXPECT_TRUE(eventually([&] { return silent(*device); }));
    EXPECT_NE(device->status().find("muted by the watchdog"), std::string::npos)
        << device->status();
}

TEST(SimulatedArray, plays_after_its_latency)
{
    const auto device = openDevice("sim:?latency=700ms", {4, {}});
    ASSERT_TRUE(device->send(evenField(4, 1, 200)));
    EXPECT_TRUE(silent(*device));
    EXPECT_TRUE(eventually([&] { return !silent(*device); }));
}

TEST(SimulatedArray, plays_as_an_open_board_would)
{
    const auto device = openDevice("sim:?board=sonicsurface", {256, {}});
    EXPECT_EQ(device->ability().phaseLevels, 32);
    EXPECT_EQ(device->ability().amplitudes, (std::vector<float>{0, 1}));
    ASSERT_TRUE(device->send(evenField(256, 3, 100))); // rounds to 0 and on
    EXPECT_NEAR(std::abs(device->played()[0] - std::complex<float>(1, 0)), 0, 1e-6);
    device->silence();
    EXPECT_TRUE(silent(*device));
}

TEST(SimulatedArray, names_what_is_wrong_with_its_parameters)
{
    const auto error = [](const std::string& uri)
    {
        try
        {
            openDevice(uri, {4, {}});
        }
        catch (const DeviceError& failure)
        {
            return std::string(failure.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(error("sim:?drop=2"),
              "device \"sim:?drop=2\": drop=2 should be a number from 0 to 1");
    EXPECT_EQ(error("sim:?drop=nan"),
              "device \"sim:?drop=nan\": drop=nan should be a number from 0 to 1");
    EXPECT_EQ(error("sim:?latency=5"),
              "device \"sim:?latency=5\": latency=5 should be a time such as 2s, 100ms or 20us");
    EXPECT_EQ(error("sim:?board=pat"),
              "device \"sim:\": board=pat should be autd3, sonicsurface, ultraino or openmpd");
    EXPECT_EQ(error("sim:?board=openmpd"),
              "device \"sim:\": board openmpd has 256 transducers, but the array has 4");
    EXPECT_EQ(error("sim:?unplug=1s"),
              "device \"sim:?unplug=1s\": unknown parameter \"unplug\"; known are board, boards, "
              "corrupt, drop, fps, hang_at, "
              "hold, latency, max-amplitude, max-pressure, mean-drive, mean-drive-time, ramp, "
              "replug_at, ringing, seed, "
              "unplug_at");
}
