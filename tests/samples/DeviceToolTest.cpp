#include "Shell.h"

#include <cstdio>

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

} // namespace

TEST(DeviceTool, says_by_its_exit_code_how_it_went)
{
    EXPECT_EQ(tool("status --device sim:").code, 0);
    EXPECT_EQ(tool("status --device sym:").code, 3);
    EXPECT_EQ(tool("status --array nowhere.json --device sim:").code, 3);
    EXPECT_EQ(tool("circle --seconds 5 --device 'sim:?unplug_at=100ms'").code, 4);
    EXPECT_EQ(tool("identify --device null:").code, 4); // has no lamps
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
    EXPECT_TRUE(says(boards, "this pattern has no control points; max-amplitude caps it"))
        << boards.output;
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
