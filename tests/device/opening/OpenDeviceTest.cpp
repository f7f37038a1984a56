#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

std::vector<std::complex<float>> decoded(const DriveSignal& signal)
{
    std::vector<std::complex<float>> q;
    decode(signal, q);
    return q;
}

const std::vector<std::complex<float>> kSilence(4);

} // namespace

TEST(OpenDevice, names_what_is_wrong_with_a_uri)
{
    EXPECT_EQ(openError("sim"),
              "device \"sim\": a device is named SCHEME:PATH?KEY=VALUE, for instance \"sim:\"");
    EXPECT_EQ(openError(""),
              "device \"\": a device is named SCHEME:PATH?KEY=VALUE, for instance \"sim:\"");
    EXPECT_EQ(openError("sim:?seed"),
              "device \"sim:?seed\": parameter \"seed\" should read KEY=VALUE");
    EXPECT_EQ(openError("null:?a=1&a=2"),
              "device \"null:?a=1&a=2\": parameter \"a\" is there twice");
    EXPECT_EQ(openError("null:?lvl=1"),
              "device \"null:?lvl=1\": unknown parameter \"lvl\"; known are boards, hold, "
              "max-amplitude, max-pressure, mean-drive, mean-drive-time, ramp");
    EXPECT_EQ(openError("null:box"),
              "device \"null:box\": nothing may stand between \"null:\" and the parameters, but "
              "\"box\" does");
    EXPECT_EQ(openError("record:"),
              "device \"record:\": the name of a file is missing: \"record:NAME\"");
    const std::string unknown = openError("sym:");
    EXPECT_EQ(unknown.find("device \"sym:\": unknown kind \"sym:\"; known are sim:, "), 0U)
        << unknown;
}

// A URI may come from a scene file: a message about it can't move a terminal's cursor, and is
// short.
TEST(OpenDevice, prints_what_it_quotes)
{
    for (const char* const uri : {"sim:?seed\x1b[2J",
                                  "null:?a\x1b=1&a\x1b=2",
                                  "sim:?seed=1\x1b[2J",
                                  "sim:?latency=1\x1b[2J",
                                  "usb:?wait=\x1b[2J",
                                  "null:?l\x1b=1",
                                  "null:b\x1bx"})
    {
        const std::string error = openError(uri);
        EXPECT_NE(error.find('?'), std::string::npos) << error;
        EXPECT_EQ(error.find('\x1b'), std::string::npos) << error;
    }
    EXPECT_LT(openError("sim:?seed=" + std::string(4000, 'x')).size(), 1000U);
}

TEST(OpenDevice, names_what_is_wrong_with_a_layout)
{
    EXPECT_EQ(openError("sim:", {0, {}}), "device layout: 0 transducers; there must be at least 1");
    EXPECT_EQ(openError("sim:", {2, {0}}),
              "device layout: board numbers for 1 transducers; there must be one for each of 2");
    EXPECT_EQ(openError("sim:", {2, {1, 1}}), "device layout: the first board is 1; it must be 0");
    EXPECT_EQ(openError("sim:", {3, {0, 0, 2}}),
              "device layout: board 2 follows board 0; they must ascend from 0 without gaps");
    EXPECT_EQ(openError("sim:", {3, {0, 1, 0}}),
              "device layout: board 0 follows board 1; they must ascend from 0 without gaps");
}

TEST(OpenDevice, says_why_a_recording_cannot_be_written)
{
    EXPECT_EQ(
        openError("record:/no/such/folder/x.midair"),
        "recording \"/no/such/folder/x.midair\": can't be written: No such file or directory");
}

class EveryDevice : public ::testing::TestWithParam<const char*>
{
protected:
    std::unique_ptr<ArrayDevice> open()
    {
        const std::string uri = GetParam();
        return openDevice(uri == "record:" ? uri + temporaryFile("fields") : uri, {4, {}});
    }
};

TEST_P(EveryDevice, starts_silent_and_plays_what_it_is_sent)
{
    const auto device = open();
    EXPECT_EQ(device->played(), kSilence);
    const DriveSignal field = randomField(4, 1);
    ASSERT_TRUE(device->send(field));
    EXPECT_EQ(device->played(), decoded(field));
    EXPECT_NE(device->status(), "");
}

TEST_P(EveryDevice, replaces_a_field_whole_or_not_at_all)
{
    const auto device = open();
    const DriveSignal field = evenField(4, 10, 200);
    ASSERT_TRUE(device->send(field));
    DriveSignal torn = evenField(4, 20, 100);
    torn.duty.pop_back();
    EXPECT_FALSE(device->send(evenField(3, 20, 100)));
    EXPECT_FALSE(device->send(evenField(5, 20, 100)));
    EXPECT_FALSE(device->send(torn));
    EXPECT_EQ(device->played(), decoded(field));
}

TEST_P(EveryDevice, is_silent_when_told_until_the_next_field)
{
    const auto device = open();
    ASSERT_TRUE(device->send(evenField(4, 10, 200)));
    device->silence();
    EXPECT_EQ(device->played(), kSilence);
    ASSERT_TRUE(device->send(evenField(4, 30, 255)));
    EXPECT_EQ(device->played(), decoded(evenField(4, 30, 255)));
}

class WouldPlay : public ::testing::TestWithParam<const char*>
{
};

TEST_P(WouldPlay, is_what_is_then_played)
{
    const DeviceLayout layout = {256, {}};
    const auto device = openDevice(GetParam(), layout);
    for (unsigned seed = 1; seed < 6; ++seed)
    {
        const DriveSignal field = randomField(256, seed);
        const auto before = device->played();
        const auto expected = device->wouldPlay(field);
        EXPECT_EQ(device->played(), before) << "nothing is sent";
        ASSERT_TRUE(device->send(field));
        const auto played = device->played();
        ASSERT_EQ(played.size(), expected.size());
        for (std::size_t i = 0; i < played.size(); ++i)
            EXPECT_LT(std::abs(played[i] - expected[i]), 1e-6F) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Uris,
                         WouldPlay,
                         ::testing::Values("sim:",
                                           "sim:?max-amplitude=0.4",
                                           "sim:?board=sonicsurface&max-amplitude=0.6",
                                           "sim:?board=ultraino",
                                           "sim:?board=openmpd&max-amplitude=0.7",
                                           "sim:?max-amplitude=0.2,null:"));

INSTANTIATE_TEST_SUITE_P(Uris, EveryDevice, ::testing::Values("sim:", "null:", "record:"));
