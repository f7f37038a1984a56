#include "device/recording/RecordingFile.h"

#include "device/ArrayDevice.h"
#include "device/recording/Recording.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <chrono>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace midair::device;

namespace
{

const std::vector<std::uint8_t> kLetter = {'D', 'e', 'a', 'r', ' ', 'A', 'd', 'a', '\n'};

std::vector<std::uint8_t> oneField()
{
    recording::Writer writer(4);
    std::vector<std::uint8_t> bytes = writer.header(0);
    const auto field = writer.field(0, evenField(4, 1, 255));
    bytes.insert(bytes.end(), field.begin(), field.end());
    const auto end = writer.mark(1, recording::Kind::END);
    bytes.insert(bytes.end(), end.begin(), end.end());
    return bytes;
}

} // namespace

TEST(RecordingFile, keeps_a_file_that_is_not_a_recording)
{
    const std::string file = temporaryFile("letter");
    for (const auto& bytes : {kLetter, std::vector<std::uint8_t>{'M'}})
    {
        writeBytes(file, bytes);
        const std::string error = openError("record:" + file);
        EXPECT_EQ(error.find("recording \"" + file + "\": "), 0U) << error;
        EXPECT_NE(error.find("record:" + file + "?overwrite=yes"), std::string::npos) << error;
        EXPECT_EQ(readBytes(file), bytes);
    }
    EXPECT_EQ(openError("record:" + file + "?overwrite=yes"), "no error");
    EXPECT_EQ(readBytes(file).size(), 32U + 20);
}

TEST(RecordingFile, replaces_a_recording_and_an_empty_file)
{
    const std::string file = temporaryFile("fields");
    writeBytes(file, oneField());
    EXPECT_EQ(openError("record:" + file), "no error");
    EXPECT_EQ(readBytes(file).size(), 32U + 20);
    writeBytes(file, {});
    EXPECT_EQ(openError("record:" + file), "no error");
    EXPECT_EQ(readBytes(file).size(), 32U + 20);
}

TEST(RecordingFile, is_never_written_through_a_link)
{
    const std::string file = temporaryFile("target");
    const std::string link = temporaryFile("link");
    const std::string why = "recording \"" + link + "\": is a link";
    const auto begin = [](const std::string& error, const std::string& of)
    { return error.substr(0, of.size()); };
    std::filesystem::create_symlink(file, link);
    EXPECT_EQ(begin(openError("record:" + link), why), why) << "to nothing";
    EXPECT_FALSE(std::filesystem::exists(file));
    for (const auto& bytes : {kLetter, oneField()})
    {
        writeBytes(file, bytes);
        EXPECT_EQ(begin(openError("record:" + link + "?overwrite=yes"), why), why);
        EXPECT_EQ(readBytes(file), bytes);
    }
    std::filesystem::remove(link);
    std::filesystem::create_hard_link(file, link);
    const std::string several = "recording \"" + link + "\": has 2 names (hard links)";
    EXPECT_EQ(begin(openError("record:" + link + "?overwrite=yes"), several), several);
    EXPECT_EQ(readBytes(file), oneField());
    std::filesystem::remove(link);
}

TEST(RecordingFile, is_no_device_no_pipe_and_no_folder)
{
    const std::string pipe = temporaryFile("pipe");
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    for (const std::string& name : {pipe, std::string("/dev/null"), std::string("/dev/full")})
        EXPECT_EQ(openError("record:" + name + "?overwrite=yes"),
                  "recording \"" + name +
                      "\": is a device or a pipe; a recording goes into a regular file");
    EXPECT_EQ(openError("play:" + pipe + "?to=null:"),
              "recording \"" + pipe + "\": is a device or a pipe, should be a regular file");
    EXPECT_EQ(openError("play:/dev/zero?to=null:"),
              "recording \"/dev/zero\": is a device or a pipe, should be a regular file");
    EXPECT_EQ(openError("record:/tmp"), "recording \"/tmp\": is a folder; name a file in it");
    EXPECT_EQ(openError("play:/tmp?to=null:"),
              "recording \"/tmp\": is a folder, should be a regular file");
    std::filesystem::remove(pipe);
}

TEST(RecordingFile, of_over_two_gibibytes_is_not_read)
{
    const std::string file = temporaryFile("large");
    writeBytes(file, oneField());
    std::error_code error;
    std::filesystem::resize_file(file, (std::uintmax_t(2) << 30) + 1, error); // a hole
    if (error) GTEST_SKIP() << "this file system has no holes: " << error.message();
    EXPECT_EQ(openError("play:" + file + "?to=null:"),
              "recording \"" + file + "\": has 2147483649 bytes, should have at most 2048 MiB");
    std::filesystem::remove(file);
}

TEST(RecordingFile, belongs_to_one_recorder_or_to_players)
{
    const std::string file = temporaryFile("fields");
    const std::string taken =
        "recording \"" + file +
        "\": is being recorded or played by somebody else; choose another name";
    {
        const recording::OpenFile other =
            recording::openForWriting(file, recording::Before::REPLACED);
        EXPECT_EQ(openError("record:" + file), taken);
    }
    EXPECT_EQ(openError("record:" + file + ",record:" + file), taken);
    writeBytes(file, oneField());
    EXPECT_EQ(openError("play:" + file + "?to=record:" + file), taken);
    EXPECT_EQ(readBytes(file), oneField());
    const auto player = openDevice("play:" + file + "?loop=yes&to=null:", {4, {}});
    EXPECT_EQ(openError("record:" + file), taken);
    EXPECT_EQ(openError("play:" + file + "?to=null:"), "no error");
}
