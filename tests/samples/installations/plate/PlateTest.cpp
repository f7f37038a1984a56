#include "tests/samples/installations/Run.h"

#include <gtest/gtest.h>

TEST(PlateInstallation, TheStarIsHeldAndFelt)
{
    const OwnFolder out("plate");
    const Visit run = visit("plate", "--frames 330", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_EQ(run.report.at("array"), "board");
    EXPECT_GT(run.report.at("fields").at("played"), 5) << run.outcome.output;
    EXPECT_GT(run.report.at("scene").at("touches"), 0);
    EXPECT_GT(run.report.at("scene").at("held_s"), 0.3);
    EXPECT_GT(run.report.at("scene").at("pointsAtMost"), 0);
}

TEST(PlateInstallation, IsRehearsedOnItsDisplay)
{
    const OwnFolder out("plate");
    const Outcome run =
        shell(std::string("'") + MIDAIR_BIN +
              "/midair-plate' --headless --frames 60 --pictures 1 " + "--out '" + out.path +
              "' --display 'sim:" MIDAIR_ROOT "/samples/displays/plate.display.json' 2>&1");
    ASSERT_EQ(run.code, 0) << run.output;
    if (run.output.find("pictures: ") == std::string::npos) // no OpenGL
    {
        EXPECT_GT(std::filesystem::file_size(out.path + "/plate_1.png"), 5000U);
    }
}

TEST(PlateInstallation, SaysWhatIsWrong)
{
    const OwnFolder out("wrong");
    EXPECT_NE(visit("plate", "--size 2", out).outcome.code, 0);
    const Visit run = visit("plate", "--model /nowhere.obj", out);
    EXPECT_NE(run.outcome.code, 0);
    EXPECT_NE(run.outcome.output.find("/nowhere.obj"), std::string::npos) << run.outcome.output;
}
