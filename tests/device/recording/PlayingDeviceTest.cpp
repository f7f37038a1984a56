#include "device/recording/PlayingDevice.h"

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/recording/Recording.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <chrono>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

// Ten fields, 20 ms apart; number i has phase i.
std::vector<std::uint8_t> show(bool whole = true)
{
    recording::Writer writer(4);
    std::vector<std::uint8_t> bytes = writer.header(0);
    for (int i = 0; i < 10; ++i)
        append(bytes,
               writer.field(20'000'000ULL * static_cast<unsigned>(i),
                            evenField(4, static_cast<std::uint8_t>(i), 255)));
    if (whole) append(bytes, writer.mark(200'000'000, recording::Kind::END));
    return bytes;
}

void waitForEnd(const ArrayDevice& device)
{
    EXPECT_TRUE(
        eventually([&] { return device.status().find("at the end") != std::string::npos; }));
}

} // namespace

TEST(PlayingDevice, plays_a_recording_at_the_recorded_times)
{
    const std::string file = temporaryFile("show");
    const std::string copy = temporaryFile("copy");
    writeBytes(file, show());
    {
        const auto device = openDevice("play:" + file + "?to=record:" + copy, {4, {}});
        EXPECT_FALSE(device->send(evenField(4, 99, 255))); // the recording is the show
        waitForEnd(*device);
    }
    const auto entries = entriesOf(copy);
    ASSERT_EQ(entries.size(), 11U); // and a silence
    for (std::size_t i = 0; i < 10; ++i)
    {
        EXPECT_EQ(entries[i].signal, evenField(4, static_cast<std::uint8_t>(i), 255));
        // Never early; how late depends on what else this machine has to do.
        EXPECT_GE(entries[i].time_ns, 20'000'000 * i);
    }
    EXPECT_EQ(entries[10].kind, recording::Kind::SILENCE);
}

TEST(PlayingDevice, plays_a_truncated_file_to_its_last_whole_field_and_says_so)
{
    const std::string file = temporaryFile("show");
    const std::string copy = temporaryFile("copy");
    std::vector<std::uint8_t> bytes = show(false);
    bytes.resize(bytes.size() - 3);
    writeBytes(file, bytes);
    std::string status;
    DeviceReport report;
    {
        const auto device = openDevice("play:" + file + "?speed=10&to=record:" + copy, {4, {}});
        waitForEnd(*device);
        status = device->status();
        report = device->report();
    }
    EXPECT_NE(report.state, DeviceState::LOST);
    EXPECT_EQ(report.faults, 0U);
    EXPECT_EQ(entriesOf(copy).size(), 9U + 1);
    EXPECT_NE(status.find("9 fields; ended without its last mark; of one more there are 18 bytes"),
              std::string::npos) // it has 21
        << status;
}

TEST(PlayingDevice, stops_at_once_when_silenced)
{
    const std::string file = temporaryFile("show");
    writeBytes(file, show());
    const auto device = openDevice("play:" + file + "?loop=yes&to=sim:", {4, {}});
    const std::vector<std::complex<float>> silent(4);
    ASSERT_TRUE(eventually([&] { return device->played() != silent; }));
    device->silence();
    waitForEnd(*device); // which it doesn't reach by itself
    EXPECT_EQ(device->played(), silent);
}

TEST(PlayingDevice, goes_on_unheard_while_muted)
{
    const std::string file = temporaryFile("show");
    writeBytes(file, show());
    const auto device = openDevice("play:" + file + "?loop=yes&to=sim:", {4, {}});
    const auto sounds = [&] { return device->played() != std::vector<std::complex<float>>(4); };
    ASSERT_TRUE(eventually(sounds));
    device->setMuted(true);
    EXPECT_FALSE(sounds());
    const std::uint64_t refused = device->report().refused;
    EXPECT_TRUE(eventually([&] { return device->report().refused > refused + 3; }));
    EXPECT_FALSE(sounds());
    EXPECT_EQ(device->report().state, DeviceState::MUTED);
    device->setMuted(false);
    EXPECT_TRUE(eventually(sounds));
}

TEST(PlayingDevice, names_what_is_wrong)
{
    const std::string file = temporaryFile("show");
    EXPECT_EQ(openError("play:" + file + "?to=null:"),
              "recording \"" + file + "\": can't be read: No such file or directory");
    writeBytes(file, {1, 2, 3});
    EXPECT_EQ(openError("play:" + file + "?to=null:"),
              "recording \"" + file +
                  "\": not a recording of fields: it doesn't start with MIDAIRF");
    writeBytes(file, recording::Writer(5).header(0));
    EXPECT_EQ(openError("play:" + file + "?to=null:"),
              "recording \"" + file + "\": was made for 5 transducers, but the array has 4");
    writeBytes(file, recording::Writer(4).header(0)); // from here on it's what follows the file
    EXPECT_NE(openError("play:" + file).find("play:FILE?to=usb:"), std::string::npos);
    for (const std::string options : {"?max-pressure=500&to=null:", "?to=null:?max-pressure=500"})
    {
        const std::string error = openError("play:" + file + options);
        EXPECT_EQ(error.find("device \"play:" + file + options + "\": max-pressure "), 0U) << error;
        EXPECT_NE(error.find("max-amplitude"), std::string::npos) << error;
    }
    EXPECT_EQ(openError("play:" + file + "?to=nil:").substr(0, 29),
              "device \"nil:\": unknown kind \"");
}

TEST(PlayingDevice, of_a_damaged_file_counts_as_failed_and_names_it)
{
    const std::string file = temporaryFile("show");
    std::vector<std::uint8_t> bytes = show();
    bytes[bytes.size() - 30] ^= 1; // in the last field
    writeBytes(file, bytes);
    const auto device = openDevice("play:" + file + "?speed=100&to=null:", {4, {}});
    waitForEnd(*device);
    const DeviceReport report = device->report();
    EXPECT_EQ(report.state, DeviceState::LOST);
    EXPECT_EQ(report.message.find("recording \"" + file + "\": the file is damaged at byte "), 0U)
        << report.message;
}

TEST(PlayingDevice, plays_on_no_other_recording)
{
    const std::string file = temporaryFile("show");
    writeBytes(file, show());
    const std::string why =
        "\": a recording plays on an array, not on another recording: \"play:\" "
        "may not stand in \"to\"";
    const std::string nested = "play:" + file + "?to=play:" + file + "?to=null:";
    EXPECT_EQ(openError(nested), "device \"" + nested + why);
    const std::string second = "play:" + file + "?to=null:,play:" + file + "?to=null:";
    EXPECT_EQ(openError(second), "device \"" + second + why);
    std::string deep;
    for (int i = 0; i < 9000; ++i)
        deep += "play:a?to=";
    EXPECT_EQ(openError(deep + "null:"),
              "device \"play:a?to=play:a?to=play:a?to=play:a?to=..\": has 90005 characters, should "
              "have at most 4096");
    EXPECT_THROW(playsByItself(deep), DeviceError);
}

// They stand with the recording, or come from the program that opens it.
TEST(PlayingDevice, keeps_the_limits_that_it_is_opened_with)
{
    for (const bool byProgram : {false, true})
    {
        const std::string file = temporaryFile("show");
        const std::string copy = temporaryFile("copy");
        writeBytes(file, show());
        {
            SafetyLimits limits;
            if (byProgram) limits.maxAmplitude = 0.2;
            const auto device = openLimitedDevice(
                "play:" + file + (byProgram ? "?" : "?max-amplitude=0.2&") + "to=record:" + copy,
                {4, {}},
                limits);
            waitForEnd(*device);
        }
        const auto entries = entriesOf(copy);
        ASSERT_EQ(entries.size(), 11U);
        for (std::size_t i = 0; i < 10; ++i)
            EXPECT_EQ(entries[i].signal.duty[0], 32) << byProgram; // asin(0.2) of 255 levels
    }
}

TEST(PlayingDevice, is_silent_under_a_hold_unless_somebody_leads)
{
    for (const bool isLed : {true, false})
    {
        const std::string file = temporaryFile("show");
        const std::string copy = temporaryFile("copy");
        writeBytes(file, show()); // 200 ms
        {
            const auto device =
                openDevice("play:" + file + "?hold=60ms&to=record:" + copy, {4, {}});
            EXPECT_TRUE(eventually(
                [&]
                {
                    if (isLed) device->keepAlive();
                    return device->status().find("at the end") != std::string::npos;
                }));
            if (isLed) device->keepAlive();
            EXPECT_EQ(device->isHoldOver(), !isLed);
        }
        const auto entries = entriesOf(copy);
        if (isLed)
            EXPECT_GE(entries.size(), 2U); // a busy machine may have led late
        else
            EXPECT_LE(entries.size(), 8U) << "those of 60 ms and of what the machine was late";
    }
}
