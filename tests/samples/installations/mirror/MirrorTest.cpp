#include "tests/samples/installations/Run.h"

#include <gtest/gtest.h>

namespace
{

const std::string kDisplays = MIDAIR_ROOT "/samples/displays/";

} // namespace

TEST(MirrorInstallation, BeatsFasterWhileItIsTouched)
{
    const OwnFolder out("mirror");
    const Visit run = visit("mirror", "--frames 300", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_EQ(run.report.at("array"), "board");
    EXPECT_GT(run.report.at("fields").at("played"), 5) << run.outcome.output;
    EXPECT_GT(run.report.at("scene").at("touches"), 0);
    EXPECT_GE(run.report.at("scene").at("beats"), 5);
    EXPECT_GT(run.report.at("scene").at("fastest_perMinute"), 75.0);
}

TEST(MirrorInstallation, IsSeenAndRehearsedOnItsDisplay)
{
    for (const std::string how : {"", "sim:"})
    {
        const OwnFolder out("mirror");
        const Outcome run =
            shell(std::string("'") + MIDAIR_BIN + "/midair-mirror' --headless --frames 30 " +
                  "--pictures 1 --out '" + out.path + "' --display '" + how + kDisplays +
                  "mirror.display.json' 2>&1");
        ASSERT_EQ(run.code, 0) << run.output;
        EXPECT_NE(run.output.find("mirror.display.json"), std::string::npos) << run.output;
        if (run.output.find("pictures: ") == std::string::npos) // no OpenGL
        {
            EXPECT_GT(std::filesystem::file_size(out.path + "/mirror_1.png"), 5000U);
        }
    }
}

// The drawings of the guide are of the displays' files.
TEST(MirrorInstallation, DrawingsAreOfTheirFiles)
{
    const OwnFolder out("drawings");
    for (const std::string name : {"mirror", "plate"})
    {
        const std::string made = out.path + "/" + name + ".svg";
        const Outcome run =
            shell("python3 -B '" + kDisplays + "draw.py' '" + kDisplays + name +
                  ".display.json' --board 150 --out '" + made + "' 2>&1 && cmp '" + made + "' '" +
                  MIDAIR_ROOT "/samples/pictures/" + name + ".svg' 2>&1");
        EXPECT_EQ(run.code, 0) << run.output;
    }
}
