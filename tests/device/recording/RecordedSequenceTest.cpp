// Sequences that a recording keeps and times by itself, through the guard that openDevice() puts
// around it.
#include "device/drive/DriveEncoder.h"
#include "device/recording/RecordingDevice.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <chrono>
#include <cmath>
#include <csignal>

#include <gtest/gtest.h>
#include <sys/resource.h>

using namespace midair::device;
using recording::Entry;
using recording::Kind;

namespace
{

// Field k has phase k.
DriveSequence numbered(int fields, double rate_Hz)
{
    DriveSequence sequence;
    sequence.rate_Hz = rate_Hz;
    for (int k = 0; k < fields; ++k)
        sequence.signals.push_back(evenField(4, static_cast<std::uint8_t>(k), 200));
    return sequence;
}

void expectSteps(const std::vector<Entry>& entries,
                 std::size_t begin,
                 std::size_t end,
                 const DriveSequence& sequence)
{
    for (std::size_t i = begin; i < end; ++i)
    {
        const std::size_t step = i - begin;
        ASSERT_EQ(entries[i].kind, Kind::FIELD);
        ASSERT_EQ(entries[i].signal, sequence.signals[step % sequence.signals.size()]) << step;
        ASSERT_EQ(entries[i].time_ns - entries[begin].time_ns,
                  std::llround(static_cast<double>(step) * 1e9 / sequence.rate_Hz));
    }
}

bool has(const std::string& file, std::size_t entries)
{
    return eventually([&] { return entriesOf(file).size() >= entries; });
}

std::uintmax_t sizeOf(const std::string& file)
{
    return std::filesystem::file_size(file);
}

} // namespace

TEST(RecordedSequence, has_every_step_at_its_time_until_the_next_field)
{
    const std::string file = temporaryFile("fields");
    {
        const auto device = openDevice("record:" + file, {4, {}});
        ASSERT_GE(device->ability().sequenceFields, 1000);
        ASSERT_TRUE(device->sendSequence(numbered(3, 700)));
        ASSERT_TRUE(has(file, 91));
        ASSERT_TRUE(device->send(evenField(4, 99, 255)));
        const DeviceReport report = device->report();
        EXPECT_EQ(report.sent, 2U); // a sequence is one
        EXPECT_EQ(report.played, 2U);
    }
    const std::vector<Entry> entries = entriesOf(file);
    ASSERT_GT(entries.size(), 90U);
    const std::size_t field = entries.size() - 2;
    expectSteps(entries, 0, field, numbered(3, 700));
    EXPECT_EQ(entries[field].signal, evenField(4, 99, 255));
    // No step is missing before it: the next one would have been due after it.
    const std::uint64_t next_ns =
        entries[0].time_ns + static_cast<std::uint64_t>(std::llround(field * 1e9 / 700));
    EXPECT_LT(entries[field].time_ns, next_ns);
    EXPECT_EQ(entries[field + 1].kind, Kind::SILENCE);
}

TEST(RecordedSequence, ends_with_silence_the_next_sequence_and_the_recording)
{
    const std::string file = temporaryFile("fields");
    {
        const auto device = openDevice("record:" + file, {4, {}});
        ASSERT_TRUE(device->sendSequence(numbered(2, 1000)));
        ASSERT_TRUE(has(file, 30));
        device->silence();
        EXPECT_EQ(device->played(), std::vector<std::complex<float>>(4));
        letPass(0.03);
        ASSERT_TRUE(device->sendSequence(numbered(5, 500)));
        ASSERT_TRUE(has(file, entriesOf(file).size() + 15));
        ASSERT_TRUE(device->sendSequence(numbered(4, 2000)));
        ASSERT_TRUE(has(file, entriesOf(file).size() + 60));
    }
    const std::vector<Entry> entries = entriesOf(file);
    std::vector<std::size_t> starts = {0};
    std::size_t silence = 0;
    while (entries[silence].kind == Kind::FIELD)
        ++silence;
    EXPECT_GE(silence, 30U);
    expectSteps(entries, 0, silence, numbered(2, 1000));
    EXPECT_GE(entries[silence + 1].time_ns - entries[silence].time_ns, 30'000'000U);
    std::size_t third = silence + 2;
    while (entries[third].signal.phase[0] != 0 ||
           (entries[third].time_ns - entries[silence + 1].time_ns) % 2'000'000 == 0)
        ++third;
    expectSteps(entries, silence + 1, third, numbered(5, 500));
    ASSERT_GE(entries.size() - 1 - third, 60U);
    expectSteps(entries, third, entries.size() - 1, numbered(4, 2000));
    EXPECT_EQ(entries.back().kind, Kind::SILENCE);
}

TEST(RecordedSequence, is_written_while_nobody_asks)
{
    const std::string file = temporaryFile("fields");
    const auto device = openDevice("record:" + file, {4, {}});
    ASSERT_TRUE(device->sendSequence(numbered(2, 1000)));
    const std::uintmax_t first = sizeOf(file);
    EXPECT_TRUE(eventually([&] { return sizeOf(file) > first + 100 * 20; }));
    // What a crash would leave is whole fields.
    expectSteps(entriesOf(file), 0, entriesOf(file).size(), numbered(2, 1000));
    device->silence();
    const std::uintmax_t last = sizeOf(file);
    letPass(0.12);
    EXPECT_EQ(sizeOf(file), last);
}

TEST(RecordedSequence, tells_which_of_its_fields_is_played)
{
    const auto device = openDevice("record:" + temporaryFile("fields"), {4, {}});
    const DriveSequence sequence = numbered(2, 20);
    ASSERT_TRUE(device->sendSequence(sequence));
    for (const DriveSignal& signal : sequence.signals)
        EXPECT_TRUE(eventually([&] { return device->played() == device->wouldPlay(signal); }));
}

TEST(RecordedSequence, plays_again_as_it_was)
{
    const std::string file = temporaryFile("show");
    const std::string copy = temporaryFile("copy");
    {
        const auto device = openDevice("record:" + file, {4, {}});
        ASSERT_TRUE(device->sendSequence(numbered(7, 200)));
        ASSERT_TRUE(has(file, 20));
    }
    {
        const auto device = openDevice("play:" + file + "?to=record:" + copy, {4, {}});
        EXPECT_EQ(device->ability().sequenceFields, 0); // the recording is the show
        EXPECT_FALSE(device->sendSequence(numbered(2, 1000)));
        EXPECT_TRUE(
            eventually([&] { return device->status().find("at the end") != std::string::npos; }));
    }
    const std::vector<Entry> shown = entriesOf(file);
    const std::vector<Entry> played = entriesOf(copy);
    ASSERT_EQ(played.size(), shown.size());
    for (std::size_t i = 0; i < shown.size(); ++i)
        EXPECT_EQ(played[i].signal, shown[i].signal);
}

TEST(RecordedSequence, that_is_not_whole_is_refused_and_what_plays_goes_on)
{
    const std::string file = temporaryFile("fields");
    const auto device = openDevice("record:" + file, {4, {}});
    ASSERT_TRUE(device->sendSequence(numbered(2, 1000)));
    DriveSequence shorter = numbered(2, 1000);
    shorter.signals[1] = evenField(3, 0, 0);
    EXPECT_FALSE(device->sendSequence(shorter));
    EXPECT_FALSE(device->sendSequence({}));
    EXPECT_FALSE(device->sendSequence(numbered(2, 0)));
    EXPECT_FALSE(device->sendSequence(numbered(device->ability().sequenceFields + 1, 1000)));
    EXPECT_FALSE(device->send(evenField(5, 0, 255)));
    const DeviceReport report = device->report();
    EXPECT_EQ(report.sent, 6U);
    EXPECT_EQ(report.refused, 5U);
    const std::uintmax_t size = sizeOf(file);
    EXPECT_TRUE(eventually([&] { return sizeOf(file) > size; }));
    device->setMuted(true);
    EXPECT_FALSE(device->sendSequence(numbered(2, 1000)));
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(4));
}

TEST(RecordedSequence, of_one_field_is_held)
{
    const std::string file = temporaryFile("fields");
    {
        const auto device = openDevice("record:" + file, {4, {}});
        ASSERT_TRUE(device->sendSequence(numbered(1, 1000)));
        letPass(0.02);
    }
    EXPECT_EQ(entriesOf(file).size(), 2U); // and a silence
}

TEST(RecordedSequence, stops_and_says_so_when_the_disk_is_full)
{
    // A limit of the file's size does for a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    const auto device = openDevice("record:" + temporaryFile("fields"), {4, {}});
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{32 + 10 * 25, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_TRUE(device->sendSequence(numbered(2, 1000)));
    const bool lost = eventually([&] { return device->report().state == DeviceState::LOST; });
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_TRUE(lost);
    const DeviceReport report = device->report();
    EXPECT_EQ(report.faults, 1U);
    EXPECT_EQ(report.message.find("writing failed after 1"), 0U) << report.message;
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(4));
    EXPECT_FALSE(device->sendSequence(numbered(2, 1000)));
}

TEST(RecordedSequence, has_each_field_held_to_the_amplitude_cap)
{
    const std::string file = temporaryFile("fields");
    DriveSequence sequence = numbered(2, 1000);
    sequence.signals[0].duty = {255, 85, 40, 0};
    sequence.signals[1].duty = {60, 50, 40, 30}; // under the cap
    {
        const auto device = openDevice("record:" + file + "?max-amplitude=0.4", {4, {}});
        ASSERT_TRUE(device->sendSequence(sequence));
        EXPECT_NE(device->status().find("limited to 40 %"), std::string::npos);
        ASSERT_TRUE(has(file, 5));
    }
    const std::vector<Entry> entries = entriesOf(file);
    ASSERT_GT(entries.size(), 4U);
    DriveSignal scaled;
    scaleDuties(sequence.signals[0], 0.4, scaled);
    EXPECT_EQ(entries[0].signal, scaled);
    EXPECT_LE(amplitudeLevels()[scaled.duty[0]], 0.4F);
    EXPECT_EQ(entries[1].signal, sequence.signals[1]);
    EXPECT_EQ(entries[2].signal, scaled);
}

TEST(RecordedSequence, is_for_the_host_to_play_where_a_limit_takes_time)
{
    const std::string file = temporaryFile("fields");
    for (const std::string limit : {"ramp=20ms", "mean-drive=0.5", "ramp=1s&max-amplitude=0.5"})
    {
        const auto device = openDevice("record:" + file + "?" + limit, {4, {}});
        EXPECT_EQ(device->ability().sequenceFields, 0) << limit;
        EXPECT_FALSE(device->sendSequence(numbered(2, 1000))) << limit;
        EXPECT_EQ(device->report().sent, 1U);
        EXPECT_EQ(device->report().refused, 1U);
    }
    EXPECT_TRUE(entriesOf(file).empty());
}

TEST(RecordedSequence, is_taken_by_no_device_that_keeps_none)
{
    for (const std::string uri : {"null:", "sim:", "null:,null:"})
    {
        const auto device = openDevice(uri, {4, {}});
        EXPECT_EQ(device->ability().sequenceFields, 0) << uri;
        EXPECT_FALSE(device->sendSequence(numbered(2, 1000))) << uri;
        EXPECT_EQ(device->report().sent, device->report().refused) << uri;
    }
}
