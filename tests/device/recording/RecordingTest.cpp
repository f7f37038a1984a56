#include "device/recording/Recording.h"

#include "device/ArrayDevice.h"
#include "device/opening/MultiDevice.h"
#include "haptics/base/Bytes.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/resource.h>

using namespace midair::device;
using recording::Kind;
using recording::Stop;

namespace
{

std::string readError(const std::vector<std::uint8_t>& bytes)
{
    try
    {
        recording::Reader(bytes.data(), bytes.size(), "show");
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "no error";
}

// Two fields of three transducers, a silence, the end.
std::vector<std::uint8_t> smallRecording()
{
    recording::Writer writer(3);
    std::vector<std::uint8_t> bytes = writer.header(1000);
    append(bytes, writer.field(5, {{1, 2, 3}, {255, 255, 255}}));
    append(bytes, writer.field(7, {{4, 5, 6}, {255, 255, 255}}));
    append(bytes, writer.mark(9, Kind::SILENCE));
    append(bytes, writer.mark(9, Kind::END));
    return bytes;
}

} // namespace

TEST(Crc32c, agrees_with_published_values)
{
    // RFC 3720, B.4, and the check value of the CRC catalogues for "123456789".
    const std::vector<std::uint8_t> zeros(32, 0);
    const std::vector<std::uint8_t> ones(32, 0xFF);
    EXPECT_EQ(midair::base::crc32c(zeros.data(), 32), 0x8A9136AAU);
    EXPECT_EQ(midair::base::crc32c(ones.data(), 32), 0x62A8AB43U);
    const auto* digits = reinterpret_cast<const std::uint8_t*>("123456789");
    EXPECT_EQ(midair::base::crc32c(digits, 9), 0xE3069283U);
    EXPECT_EQ(midair::base::crc32c(digits + 4, 5, midair::base::crc32c(digits, 4)), 0xE3069283U);
    EXPECT_EQ(midair::base::crc32c(digits, 0), 0U);
}

TEST(Recording, is_laid_out_as_documented)
{
    std::vector<std::uint8_t> bytes = smallRecording();
    const std::vector<std::uint8_t> header = {'M', 'I', 'D', 'A', 'I', 'R', 'F', '\n', 1, 0,
                                              32,  0,   3,   0,   0,   0,   232, 3,    0, 0,
                                              0,   0,   0,   0,   0,   0,   0,   0};
    EXPECT_TRUE(std::equal(header.begin(), header.end(), bytes.begin()));
    const std::vector<std::uint8_t> first = {1, 0, 1, 0, 4, 0, 0, 0, 5, 0,
                                             0, 0, 0, 0, 0, 0, 1, 2, 3, 255};
    EXPECT_TRUE(std::equal(first.begin(), first.end(), bytes.begin() + 32));
    const std::vector<std::uint8_t> second = {
        1, 0, 2, 0, 3, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 4, 5, 6};
    EXPECT_TRUE(std::equal(second.begin(), second.end(), bytes.begin() + 32 + 24));
    EXPECT_EQ(bytes.size(), 32U + 24 + 23 + 20 + 20);
}

TEST(Recording, reads_what_was_written)
{
    const std::vector<std::uint8_t> bytes = smallRecording();
    recording::Reader reader(bytes.data(), bytes.size(), "show");
    EXPECT_EQ(reader.transducers(), 3);
    EXPECT_EQ(reader.start_ns(), 1000U);
    recording::Entry entry;
    ASSERT_EQ(reader.next(entry), Stop::MORE);
    EXPECT_EQ(entry.time_ns, 5U);
    EXPECT_EQ(entry.signal, (DriveSignal{{1, 2, 3}, {255, 255, 255}}));
    ASSERT_EQ(reader.next(entry), Stop::MORE);
    EXPECT_EQ(entry.signal, (DriveSignal{{4, 5, 6}, {255, 255, 255}}));
    ASSERT_EQ(reader.next(entry), Stop::MORE);
    EXPECT_EQ(entry.kind, Kind::SILENCE);
    EXPECT_EQ(entry.signal.duty, std::vector<std::uint8_t>(3, 0));
    EXPECT_EQ(reader.next(entry), Stop::END);
}

TEST(Recording, cut_short_anywhere_gives_its_last_whole_field)
{
    const std::vector<std::uint8_t> bytes = smallRecording();
    for (std::size_t size = recording::kHeaderBytes; size < bytes.size(); ++size)
    {
        const std::vector<std::uint8_t> cut(bytes.begin(),
                                            bytes.begin() + static_cast<std::ptrdiff_t>(size));
        recording::Reader reader(cut.data(), cut.size(), "show");
        recording::Entry entry;
        int whole = 0;
        while (reader.next(entry) == Stop::MORE)
            ++whole;
        EXPECT_EQ(reader.next(entry), Stop::TRUNCATED) << size;
        EXPECT_EQ(whole, size < 56 ? 0 : size < 79 ? 1 : size < 99 ? 2 : 3) << size;
    }
}

TEST(Recording, with_any_bit_flipped_is_noticed)
{
    const std::vector<std::uint8_t> bytes = smallRecording();
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit)
    {
        std::vector<std::uint8_t> bad = bytes;
        bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
        if (bit / 8 < recording::kHeaderBytes)
        {
            EXPECT_NE(readError(bad), "no error") << bit;
            continue;
        }
        recording::Reader reader(bad.data(), bad.size(), "show");
        recording::Entry entry;
        Stop stop = Stop::MORE;
        while (stop == Stop::MORE)
            stop = reader.next(entry);
        EXPECT_TRUE(stop == Stop::CORRUPT || stop == Stop::TRUNCATED) << bit;
    }
}

TEST(Recording, says_what_is_wrong_with_a_header)
{
    EXPECT_EQ(readError({}),
              "recording \"show\": not a recording of fields: it doesn't start with MIDAIRF");
    std::vector<std::uint8_t> bytes = smallRecording();
    bytes[8] = 2;
    EXPECT_EQ(readError(bytes),
              "recording \"show\": format version 2, but this program reads version 1");
    bytes[8] = 1;
    bytes[12] = 4;
    EXPECT_EQ(readError(bytes), "recording \"show\": the header is damaged");
    EXPECT_EQ(readError({bytes.begin(), bytes.begin() + 20}),
              "recording \"show\": the header is damaged");
    recording::Writer none(0);
    EXPECT_EQ(readError(none.header(0)),
              "recording \"show\": 0 transducers, should be 1 to 1048576");
}

TEST(RecordingDevice, writes_fields_silences_and_the_end)
{
    const std::string file = temporaryFile("fields");
    {
        const auto device = openDevice("record:" + file, {3, {}});
        device->silence(); // silent already: nothing to record
        ASSERT_TRUE(device->send({{1, 2, 3}, {9, 9, 9}}));
        device->silence();
        ASSERT_TRUE(device->send({{1, 2, 3}, {9, 9, 10}}));
    }
    const std::vector<std::uint8_t> bytes = readBytes(file);
    recording::Reader reader(bytes.data(), bytes.size(), file);
    std::vector<Kind> kinds;
    std::uint64_t last_ns = 0;
    recording::Entry entry;
    Stop stop = reader.next(entry);
    for (; stop == Stop::MORE; stop = reader.next(entry))
    {
        kinds.push_back(entry.kind);
        EXPECT_GE(entry.time_ns, last_ns);
        last_ns = entry.time_ns;
    }
    EXPECT_EQ(stop, Stop::END);
    EXPECT_EQ(kinds,
              (std::vector<Kind>{
                  Kind::FIELD, Kind::SILENCE, Kind::FIELD, Kind::SILENCE})); // closing silences
}

TEST(RecordingDevice, is_silent_and_says_so_when_the_disk_is_full)
{
    // A limit of the file's size does for a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{40, before.rlim_max};
    const auto device = openDevice("record:" + temporaryFile("fields"), {3, {}});
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_FALSE(device->send({{1, 2, 3}, {9, 9, 9}}));
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    const DeviceReport report = device->report();
    EXPECT_EQ(report.state, DeviceState::LOST);
    EXPECT_EQ(report.message, "writing failed after 0 fields: File too large");
    EXPECT_EQ(device->played(), std::vector<std::complex<float>>(3));
}

TEST(RecordingDevice, goes_on_with_what_this_program_has_recorded)
{
    const std::string file = temporaryFile("continued");
    for (int i = 0; i < 3; ++i)
    {
        const auto device = openDevice("record:" + file + "?continue=yes", {3, {}});
        ASSERT_TRUE(device->send({{1, 2, 3}, {9, 9, static_cast<std::uint8_t>(9 + i)}}));
    }
    const std::vector<std::uint8_t> bytes = readBytes(file);
    recording::Reader reader(bytes.data(), bytes.size(), file);
    recording::Entry entry;
    std::vector<int> duties; // of the last transducer; -1: silence
    Stop stop = reader.next(entry);
    for (; stop == Stop::MORE; stop = reader.next(entry))
        duties.push_back(entry.kind == Kind::FIELD ? entry.signal.duty[2] : -1);
    EXPECT_EQ(stop, Stop::END);
    EXPECT_EQ(duties, (std::vector<int>{9, -1, 10, -1, 11, -1}));

    EXPECT_THROW(openDevice("record:" + file + "?continue=yes", {4, {}}), DeviceError);
    EXPECT_EQ(readBytes(file), bytes) << "of another array: it stays";
    {
        const auto anew = openDevice("record:" + file, {3, {}});
    }
    EXPECT_LT(readBytes(file).size(), bytes.size()) << "as ever, a new one replaces it";

    // Somebody else's recording isn't continued; what is none, isn't touched.
    std::filesystem::copy_file(file, file + ".other");
    {
        const auto other = openDevice("record:" + file + ".other?continue=yes", {3, {}});
    }
    std::ofstream(file + ".text") << "no recording";
    EXPECT_THROW(openDevice("record:" + file + ".text?continue=yes", {3, {}}), DeviceError);
    std::filesystem::remove(file + ".other");
    std::filesystem::remove(file + ".text");
}

TEST(RecordingDevice, goes_on_after_a_full_disk_without_what_was_cut_off)
{
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const std::string file = temporaryFile("cut");
    {
        const auto device = openDevice("record:" + file, {3, {}});
        ASSERT_TRUE(device->send({{1, 2, 3}, {9, 9, 9}}));
        const rlimit small{readBytes(file).size() + 5, before.rlim_max};
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
        device->silence();
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
        EXPECT_EQ(device->report().state, DeviceState::LOST) << "also where a mark is not written";
        EXPECT_FALSE(device->send({{1, 2, 3}, {9, 9, 8}}));
    }
    {
        const auto device = openDevice("record:" + file + "?continue=yes", {3, {}});
        EXPECT_TRUE(device->send({{1, 2, 3}, {9, 9, 7}}));
    }
    const std::vector<std::uint8_t> bytes = readBytes(file);
    recording::Reader reader(bytes.data(), bytes.size(), file);
    recording::Entry entry;
    int fields = 0;
    Stop stop = reader.next(entry);
    for (; stop == Stop::MORE; stop = reader.next(entry))
        fields += entry.kind == Kind::FIELD ? 1 : 0;
    EXPECT_EQ(stop, Stop::END);
    EXPECT_EQ(fields, 2);
}

TEST(ContinuedRecordings, are_those_of_a_list)
{
    EXPECT_EQ(continuedRecordings("sim:"), "sim:");
    EXPECT_EQ(continuedRecordings("record:a"), "record:a?continue=yes");
    EXPECT_EQ(continuedRecordings("record:a?continue=yes"), "record:a?continue=yes");
    EXPECT_EQ(continuedRecordings("usb:,record:a?overwrite=yes"),
              "usb:,record:a?overwrite=yes&continue=yes");
}
