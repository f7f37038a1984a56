#include "device/opening/MultiDevice.h"

#include "device/ArrayDevice.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <gtest/gtest.h>

using namespace midair::device;

TEST(MultiDevice, cuts_a_field_by_boards)
{
    const DeviceLayout layout = {6, {0, 0, 1, 1, 2, 2}};
    const std::string first = temporaryFile("first");
    const std::string second = temporaryFile("second");
    const std::string all = temporaryFile("all,whole"); // a comma that is part of a name
    const DriveSignal field = randomField(6, 1);
    {
        const auto device = openDevice(
            "record:" + first + "?boards=0,record:" + second + "?boards=1-2,record:" + all, layout);
        ASSERT_TRUE(device->send(field));
        EXPECT_EQ(device->report().sent, 3U);
        EXPECT_EQ(device->report().played, 3U);
    }
    EXPECT_EQ(entriesOf(first)[0].signal.phase,
              std::vector<std::uint8_t>(field.phase.begin(), field.phase.begin() + 2));
    EXPECT_EQ(entriesOf(second)[0].signal.duty,
              std::vector<std::uint8_t>(field.duty.begin() + 2, field.duty.end()));
    EXPECT_EQ(entriesOf(all)[0].signal, field);
}

TEST(MultiDevice, plays_on_when_one_is_lost_and_reports_it)
{
    const auto device = openDevice("sim:,sim:?unplug_at=0s", {4, {}});
    EXPECT_FALSE(device->send(evenField(4, 1, 255)));
    EXPECT_GT(std::abs(device->played()[0]), 0.9);
    EXPECT_EQ(device->report().state, DeviceState::LOST);
    EXPECT_EQ(device->report().message, "unplugged");
    device->setMuted(true);
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(4));
}

TEST(MultiDevice, measures_the_skew)
{
    const auto device = openDevice("sim:,null:", {4, {}});
    for (int i = 0; i < 10; ++i)
        ASSERT_TRUE(device->send(evenField(4, 1, 255)));
    const DeviceReport report = device->report();
    EXPECT_GT(report.skew_s, 0);
    EXPECT_GE(report.worstSkew_s, report.skew_s);
    EXPECT_LT(report.skew_s, 1); // a time within the sends, not since 1970
}

TEST(MultiDevice, is_as_coarse_as_the_coarsest)
{
    const auto device = openDevice("sim:,sim:?board=sonicsurface", {256, {}});
    EXPECT_EQ(device->ability().phaseLevels, 32);
    EXPECT_EQ(device->ability().amplitudes.size(), 2U);
}

TEST(MultiDevice, names_transducers_that_nobody_has)
{
    const DeviceLayout layout = {6, {0, 0, 1, 1, 2, 2}};
    const auto error = [&](const std::string& uri) { return openError(uri, layout); };
    EXPECT_EQ(error("null:?boards=0,null:?boards=2"),
              "device \"null:?boards=0,null:?boards=2\": no device has transducer 2 of 6");
    EXPECT_EQ(error("null:?boards=1-3"),
              "device \"null:?boards=1-3\": boards=1-3 should be a board or a range of them, from "
              "0 to 2");
    EXPECT_EQ(
        error("null:?boards=x"),
        "device \"null:?boards=x\": boards=x should be a board or a range of them, from 0 to 2");
}

TEST(MultiDevice, is_a_list_of_limited_length)
{
    const auto list = [](int count)
    {
        std::string text = "null:";
        for (int i = 1; i < count; ++i)
            text += ",null:";
        return text;
    };
    EXPECT_EQ(openError(list(64)), "no error");
    EXPECT_EQ(openError(list(65)),
              "device \"null:,null:,null:,null:,null:,null:,null..\": is a list of 65 devices, "
              "should be at most 64");
}

TEST(MultiDevice, is_as_slow_as_the_slowest)
{
    EXPECT_EQ(openDevice("sim:,null:", {256, {}})->ability().fieldsPerSecond, 0);
    EXPECT_EQ(openDevice("sim:?fps=90,sim:?fps=70,null:", {256, {}})->ability().fieldsPerSecond,
              70);
}
