#include "samples/shared/ToolOptions.h"

#include "tests/samples/Shell.h"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

using namespace midair::samples;

TEST(ToolOptions, HelpSaysRangeAndDefaultBehindTheText)
{
    CLI::App app;
    int frames = 30;
    bool isOn = false;
    const auto* counted = app.add_option("--frames", frames, "frames to play")
                              ->check(CLI::Range(1, 100))
                              ->capture_default_str();
    std::string word;
    app.add_option("--word", word, "what")->check(CLI::IsMember({"a", "b"}))->excludes("--frames");
    app.add_flag("--on", isOn, "switches it on");
    ASSERT_NE(counted, nullptr);
    useToolHelp(app);
    const std::string help = app.help();
    for (const char* said : {"--frames INT",
                             "frames to play (1 .. 100; default 30; not with --word)",
                             "--word TEXT",
                             "what (a, b; not with --frames)"})
        EXPECT_NE(help.find(said), std::string::npos) << said << "\n" << help;
    for (const char* noise : {" in [", "Excludes", "INT:"})
        EXPECT_EQ(help.find(noise), std::string::npos) << help;
}

TEST(ToolOptions, AWrongOptionEndsEveryProgramWithTwo)
{
    int programs = 0;
    for (const char* name :
         {"bake",    "calibrate", "check", "coincide", "demo",   "desk",  "device",
          "display", "gallery",   "hands", "jnd",      "mirror", "paper", "piano",
          "plate",   "solve",     "sweep", "toybox",   "tune",   "water"})
    {
        const std::string program = std::string(MIDAIR_BIN "/midair-") + name;
        if (!std::filesystem::exists(program)) continue;
        ++programs;
        const Outcome wrong = shell(program + " --no-such-option");
        EXPECT_EQ(wrong.code, 2) << name << wrong.output;
        const Outcome help = shell(program + " --help");
        EXPECT_EQ(help.code, 0) << name;
        EXPECT_EQ(help.output.find(" in ["), std::string::npos) << name << help.output;
    }
    EXPECT_GT(programs, 10);
}
