#include "tests/device/limits/UserCapTexts.h"
#include "tests/samples/Shell.h"

#include <cstdio>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <unistd.h>

namespace
{

Outcome tool(const std::string& arguments)
{
    return shell(std::string(MIDAIR_BIN) + "/midair-device " + arguments);
}

bool says(const Outcome& outcome, const std::string& text)
{
    return outcome.output.find(text) != std::string::npos;
}

/// A file of the test's own, gone at its end.
class OwnFile
{
public:
    explicit OwnFile(const std::string& name) :
        path(::testing::TempDir() + std::to_string(::getpid()) + "_" + name)
    {
        std::remove(path.c_str());
    }
    ~OwnFile() { std::remove(path.c_str()); }
    OwnFile(const OwnFile&) = delete;
    OwnFile& operator=(const OwnFile&) = delete;

    const std::string path;
};

/// A recording of 64 fields for ultraino64.
void record(const std::string& file)
{
    const Outcome made =
        tool("transducers --array ultraino64 --seconds 0.2 --device record:" + file);
    ASSERT_EQ(made.code, 0) << made.output;
}

std::string contents(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write(const std::string& file, const std::string& text)
{
    std::ofstream(file, std::ios::binary) << text;
}

} // namespace

TEST(DeviceTool, says_by_its_exit_code_how_it_went)
{
    EXPECT_EQ(tool("status --device sim:").code, 0);
    EXPECT_EQ(tool("status --device sym:").code, 3);
    EXPECT_EQ(tool("status --array nowhere.json --device sim:").code, 2);
    EXPECT_EQ(tool("status --rate fast").code, 2);
    EXPECT_EQ(tool("circle --seconds 5 --device 'sim:?unplug_at=100ms'").code, 3);
    EXPECT_EQ(tool("identify --device null:").code, 3); // has no lamps
    EXPECT_EQ(tool("identify --device sim: --board 99").code, 3);
    EXPECT_NE(tool("").code, 0);
    EXPECT_EQ(tool("--help").code, 0);
}

TEST(DeviceTool, names_the_firmware_and_the_kinds_of_devices)
{
    EXPECT_TRUE(says(tool("status --device sim:"), "firmware 1.0.0"));
    EXPECT_TRUE(says(tool("--help"), "sonicsurface:TTY"));
}

TEST(DeviceTool, plays_its_patterns)
{
    const Outcome boards = tool("boards --device sim: --seconds 0.2");
    EXPECT_TRUE(says(boards, "board 15 of 16")) << boards.output;
    EXPECT_TRUE(says(boards, "16 sent, 16 played")) << boards.output;
    const Outcome each =
        tool("transducers --array ultraino64 --device 'sim:?board=ultraino' --seconds 0.2");
    EXPECT_TRUE(says(each, "64 sent, 64 played")) << each.output;
    const Outcome circle = tool("circle --device sim: --seconds 0.2");
    EXPECT_EQ(circle.code, 0) << circle.output;
    const Outcome rates = tool("measure --device sim:,null: --seconds 0.2");
    EXPECT_TRUE(says(rates, "latency   median ")) << rates.output;
    EXPECT_TRUE(says(rates, "skew ")) << rates.output;
}

TEST(DeviceTool, keeps_to_a_cap_of_pressure_where_there_is_a_point)
{
    const std::string capped = " --device 'sim:?max-pressure=500' --seconds 0.2";
    EXPECT_EQ(tool("circle" + capped).code, 0);
    const Outcome boards = tool("boards" + capped);
    EXPECT_EQ(boards.code, 3);
    EXPECT_TRUE(says(boards, "max-pressure") && says(boards, "max-amplitude")) << boards.output;
}

// As scenes have it, in tests/plugin/engine/EarsTest.cpp, and with the same texts.
TEST(DeviceTool, understands_the_users_caps_or_plays_nothing)
{
    const std::string file = ::testing::TempDir() + std::to_string(::getpid()) + "_caps.midair";
    ASSERT_EQ(tool("transducers --array ultraino64 --seconds 0.1 --device record:" + file).code, 0);
    for (const UserCapText& one : userCapTexts())
    {
        const SetVariable variable(one.variable, one.text);
        const bool plays = one.isUnderstood && !one.needsPoints;
        for (const std::string& command : {std::string("boards --seconds 0.02"), "play " + file})
        {
            const Outcome made = tool(command + " --array ultraino64 --device sim:");
            EXPECT_EQ(made.code, plays ? 0 : 3)
                << command << " " << one.variable << "=" << one.text << ": " << made.output;
            if (!one.isUnderstood)
            {
                EXPECT_TRUE(says(made, std::string(one.variable) + " is \"")) << made.output;
            }
        }
    }
    const SetVariable wrong("OSG_MIDAIR_EAR_LIMIT", "quiet");
    EXPECT_EQ(tool("mute --array ultraino64 --device sim:").code, 0) << "silence needs no limit";
    std::remove(file.c_str());
}

TEST(DeviceTool, holds_patterns_and_recordings_to_the_users_ear_limit)
{
    const std::string file = ::testing::TempDir() + std::to_string(::getpid()) + "_ears.midair";
    ASSERT_EQ(tool("circle --amplitude 1 --seconds 0.05 --device record:" + file).code, 0);
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "120");
    const std::string held = "held down to the ear limit of 120 dB";
    const Outcome circle = tool("circle --amplitude 1 --seconds 0.05 --device sim:");
    EXPECT_EQ(circle.code, 0) << circle.output;
    EXPECT_TRUE(says(circle, held)) << circle.output;
    const Outcome show = tool("play " + file + " --device sim:");
    EXPECT_EQ(show.code, 0) << show.output;
    EXPECT_TRUE(says(show, held)) << show.output;
    const Outcome itself = tool("boards --device 'play:" + file + "?to=sim:'");
    EXPECT_EQ(itself.code, 3) << itself.output;
    EXPECT_TRUE(says(itself, "it plays by itself")) << itself.output;
    EXPECT_EQ(tool("status --device 'play:" + file + "?to=sim:'").code, 3);
    std::remove(file.c_str());
}

TEST(DeviceTool, records_and_plays)
{
    const std::string file = ::testing::TempDir() + std::to_string(::getpid()) + "_tool.midair";
    EXPECT_EQ(tool("transducers --array ultraino64 --seconds 0.2 --device record:" + file).code, 0);
    const Outcome show = tool("play " + file + " --array ultraino64 --device sim:");
    EXPECT_EQ(show.code, 0);
    EXPECT_TRUE(says(show, "at the end, 64 fields -> sim: 64 transducers, 64 sent, 64 played"))
        << show.output;
    std::remove(file.c_str());
}

TEST(DeviceTool, fails_where_less_than_half_is_played)
{
    for (const char* pattern : {"circle --rate 200", "measure --rate 200", "boards", "transducers"})
    {
        const Outcome bad =
            tool(std::string(pattern) + " --seconds 0.5 --device 'sim:?drop=0.2&corrupt=0.2'");
        EXPECT_EQ(bad.code, 3) << pattern << bad.output;
        EXPECT_TRUE(says(bad, " fields were played: ")) << bad.output;
    }
    EXPECT_EQ(tool("circle --rate 200 --seconds 0.5 --device 'sim:?drop=0.001'").code, 0);
}

TEST(DeviceTool, waits_for_an_array_that_is_not_there_yet)
{
    const Outcome never = tool("circle --device 'usb:?wait=yes' --seconds 0.3");
    EXPECT_EQ(never.code, 3) << never.output;
    EXPECT_TRUE(says(never, "\"usb:?wait=yes\", at most 0.3 s: usb:")) << never.output;
    const std::string late = " --seconds 6 --device 'sim:?unplug_at=0s&replug_at=2s'";
    const Outcome comes = tool("boards" + late);
    EXPECT_EQ(comes.code, 0) << comes.output;
    EXPECT_TRUE(says(comes, "waiting for \"sim:")) << comes.output;
    EXPECT_TRUE(says(comes, "16 sent, 16 played")) << comes.output;
}

TEST(DeviceTool, names_the_recording_that_it_could_not_play)
{
    const OwnFile file("tool,with?odd&to=name.midair");
    const std::string quoted = "'" + file.path + "'";
    const std::string on = " --array ultraino64 --device sim:";
    const auto fails = [&](const std::string& rest, int code, const std::string& why)
    {
        const Outcome outcome = tool("play " + quoted + rest);
        EXPECT_EQ(outcome.code, code) << outcome.output;
        EXPECT_TRUE(says(outcome, "recording \"" + file.path + "\"") && says(outcome, why))
            << outcome.output;
    };
    fails(on, 3, "can't be read: No such file or directory");
    const OwnFile plain("tool_show.midair");
    record(plain.path);
    const std::string whole = contents(plain.path);
    write(file.path, whole);
    EXPECT_EQ(tool("play " + quoted + on).code, 0);
    fails(" --array board --device sim:", 3, "was made for 64 transducers, but the array has 249");
    fails(on + "'?unplug_at=50ms'", 3, "the device failed: unplugged");
    std::string damaged = whole;
    damaged[damaged.size() - 100] ^= 1;
    write(file.path, damaged);
    fails(on, 3, "damaged at byte");
    write(file.path, "a letter");
    fails(on, 3, "not a recording of fields");
    write(file.path, whole);
    const Outcome nested = tool("play " + quoted + " --array ultraino64 --device 'play:x?to=sim:'");
    EXPECT_EQ(nested.code, 3);
    EXPECT_TRUE(says(nested, "can only be played on an array")) << nested.output;
    // Nor is what is played recorded over.
    EXPECT_EQ(tool("play " + plain.path + " --array ultraino64 --device record:" + plain.path).code,
              3);
    EXPECT_EQ(contents(plain.path), whole);
}

// As by SIGTERM or SIGKILL, which leave no last mark; the array is simulated if none is named.
TEST(DeviceTool, plays_what_there_is_of_a_recording_that_was_killed)
{
    const OwnFile file("tool_killed.midair");
    record(file.path);
    const std::string whole = contents(file.path);
    const std::size_t mark_bytes = 20;
    // Behind the last field and its silence, and within a field.
    for (const std::size_t missing : {mark_bytes, 2 * mark_bytes + 3})
    {
        write(file.path, whole.substr(0, whole.size() - missing));
        const Outcome played = tool("play " + file.path + " --array ultraino64");
        EXPECT_EQ(played.code, 0) << played.output;
        EXPECT_TRUE(says(played,
                         missing == mark_bytes
                             ? "64 fields, ended without its last mark"
                             : "63 fields, ended without its last mark; of one more there "
                               "are "))
            << played.output;
        EXPECT_TRUE(says(played, "--device")) << played.output;
        EXPECT_TRUE(says(played, " -> sim: 64 transducers")) << played.output;
    }
}

TEST(DeviceTool, makes_an_array_of_a_pat_file)
{
    const OwnFile pat("board.pat");
    const OwnFile json("board.json");
    std::string places;
    std::string pins;
    std::string phases;
    std::string ones;
    for (int t = 0; t < 256; ++t)
    {
        const int column = t / 16;
        places += "(" + std::to_string((column - 7.5) * 0.0105) + ", " +
                  std::to_string((7.5 - t % 16) * 0.0105) + ", 0.000000),";
        pins += std::to_string(255 - t) + ",";
        phases += std::to_string(t - 128) + ",";
        ones += "1.000000,";
    }
    write(pat.path,
          "FT000001\n256\n128\n" + places + "\n" + pins + "\n" + phases + "\n" + ones + "\n");
    const std::string import = "import-pat " + pat.path + " --out " + json.path;
    const Outcome made = tool(import);
    EXPECT_EQ(made.code, 0) << made.output;
    EXPECT_TRUE(says(made, "--device openmpd:FT000001")) << made.output;
    EXPECT_EQ(
        tool("boards --seconds 0.1 --array " + json.path + " --device 'sim:?board=openmpd'").code,
        0);
    write(pat.path, "FT000001\n255\n");
    const Outcome wrong = tool(import);
    EXPECT_EQ(wrong.code, 2);
    EXPECT_TRUE(
        says(wrong, pat.path + ", line 2: is \"255\"; it must be the number of transducers, 256"))
        << wrong.output;
    const Outcome device = tool("import-pat /dev/zero --out " + json.path);
    EXPECT_EQ(device.code, 2);
    EXPECT_TRUE(says(device, "/dev/zero: is a device or a pipe, should be a regular file"))
        << device.output;
}

TEST(DeviceTool, makes_an_array_file_of_a_simulation_of_ultraino)
{
    const OwnFile xml("simulation.xml");
    const OwnFile json("simulation.json");
    const std::string kinds = "class=\"acousticfield3d.simulation.";
    std::string list;
    for (const char* id : {"T0", "T1"})
        list += "<void method=\"add\"><object " + kinds + "Transducer\" id=\"" + id +
                "\"><void property=\"driverPinNumber\"><int>" +
                (id[1] + std::string("</int></void>")) + "</object></void>";
    write(xml.path,
          "<java class=\"java.beans.XMLDecoder\"><object " + kinds +
              "Simulation\" id=\"S\"/><void " + kinds +
              "Simulation\" method=\"getField\"><string>transducers</string><void " +
              "method=\"get\"><object idref=\"S\"/>" + list + "</void></void></java>");
    const std::string import = "import-ultraino " + xml.path + " --out " + json.path;
    const Outcome made = tool(import);
    EXPECT_EQ(made.code, 0) << made.output;
    EXPECT_TRUE(says(made, "2 transducers; play on it with --array " + json.path)) << made.output;
    EXPECT_EQ(tool("transducers --seconds 0.1 --array " + json.path + " --device null:").code, 0);
    write(xml.path, "<java>");
    const Outcome wrong = tool(import);
    EXPECT_EQ(wrong.code, 2);
    EXPECT_TRUE(says(wrong, xml.path + ", line 1: no element found")) << wrong.output;
}
