#include "device/recording/PlayingDevice.h"

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/recording/Recording.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

void append(std::vector<std::uint8_t>& all, const std::vector<std::uint8_t>& more)
{
    all.insert(all.end(), more.begin(), more.end());
}

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

std::vector<recording::Entry> entriesOf(const std::string& file)
{
    const auto bytes = readBytes(file);
    recording::Reader reader(bytes.data(), bytes.size(), file);
    std::vector<recording::Entry> entries;
    recording::Entry entry;
    while (reader.next(entry) == recording::Stop::MORE)
        entries.push_back(entry);
    return entries;
}

void waitForEnd(const ArrayDevice& device)
{
    for (int i = 0; i < 2000 && device.status().find("at the end") == std::string::npos; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

std::string openError(const std::string& uri)
{
    try
    {
        openDevice(uri, {4, {}});
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "no error";
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
        EXPECT_GE(entries[i].time_ns - entries[0].time_ns + 15'000'000,
                  20'000'000 * i); // the first may be late itself
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
    {
        const auto device = openDevice("play:" + file + "?speed=10&to=record:" + copy, {4, {}});
        waitForEnd(*device);
        status = device->status();
    }
    EXPECT_EQ(entriesOf(copy).size(), 9U + 1);
    const std::size_t offset =
        bytes.size() - 18; // the last record has 21 bytes, of which three are gone
    EXPECT_NE(status.find("the file breaks off at byte " + std::to_string(offset) + " of " +
                          std::to_string(bytes.size()) + ", after 9 whole fields"),
              std::string::npos)
        << status;
}

TEST(PlayingDevice, stops_at_once_when_silenced)
{
    const std::string file = temporaryFile("show");
    writeBytes(file, show());
    const auto device = openDevice("play:" + file + "?loop=yes&to=sim:", {4, {}});
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    device->silence();
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(4));
    EXPECT_NE(device->status().find("at the end"), std::string::npos) << device->status();
}

TEST(PlayingDevice, goes_on_unheard_while_muted)
{
    const std::string file = temporaryFile("show");
    writeBytes(file, show());
    const auto device = openDevice("play:" + file + "?loop=yes&to=sim:", {4, {}});
    const auto sounds = [&] { return device->played() != std::vector<std::complex<float>>(4); };
    const auto eventually = [](const auto& condition)
    {
        for (int i = 0; i < 5000 && !condition(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        return condition();
    };
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
    EXPECT_EQ(openError("play:" + file),
              "device \"play:" + file + "\": say on which device: \"play:FILE?to=usb:\"");
    const std::string noPoints = "\": max-pressure can't be held: a recording has no control "
                                 "points. It holds what was capped "
                                 "when it was recorded; max-amplitude caps it again";
    for (const std::string options : {"?max-pressure=500&to=null:", "?to=null:?max-pressure=500"})
        EXPECT_EQ(openError("play:" + file + options),
                  "device \"play:" + file + options + noPoints);
    EXPECT_EQ(openError("play:" + file + "?to=nil:").substr(0, 29),
              "device \"nil:\": unknown kind \"");
}

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
    const auto error = [](const std::string& uri)
    {
        try
        {
            openDevice(uri, {6, {0, 0, 1, 1, 2, 2}});
        }
        catch (const DeviceError& failure)
        {
            return std::string(failure.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(error("null:?boards=0,null:?boards=2"),
              "device \"null:?boards=0,null:?boards=2\": no device has transducer 2 of 6");
    EXPECT_EQ(error("null:?boards=1-3"),
              "device \"null:?boards=1-3\": boards=1-3 should be a board or a range of them, from "
              "0 to 2");
    EXPECT_EQ(
        error("null:?boards=x"),
        "device \"null:?boards=x\": boards=x should be a board or a range of them, from 0 to 2");
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
