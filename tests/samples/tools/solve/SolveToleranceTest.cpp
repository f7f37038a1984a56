// midair-solve --tolerance and its transducers by number, as a user runs it.
#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/SolveOutput.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;

const std::string kSolve =
    MIDAIR_BIN "/midair-solve " MIDAIR_ROOT "/samples/models/star.obj --size 0.08 ";

std::string folder(const std::string& name)
{
    std::string path = testing::TempDir() + "midair-solve-tolerance-" + name;
    fs::remove_all(path);
    return path;
}

} // namespace

TEST(SolveTolerance, WritesATableAndAPicture)
{
    const std::string out = folder("table");
    const Outcome outcome =
        shell(kSolve +
              "--tolerance --tolerance-draws 3 --tolerance-position 0.2mm,1mm "
              "--tolerance-tilt 0.1 --tolerance-phase 15 --tolerance-temperature -1,2 "
              "--tolerance-dead 10% --out " +
              out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("tolerance   18 arrays "), std::string::npos) << outcome.output;
    std::string header;
    const auto rows = readCsv(out + "/tolerance.csv", &header);
    EXPECT_EQ(header,
              "deviation,value,unit,draws,rms,rms_p90,loudness,loudness_p10,focus,focus_p10,"
              "expected_rms,expected_focus");
    ASSERT_EQ(rows.size(), 8U);
    EXPECT_NEAR(rows[0][8], 1.0, 1e-4) << "as it was meant";
    EXPECT_NEAR(rows[1][1], 2e-4, 1e-9);
    EXPECT_EQ(rows[5][1], -1.0);
    EXPECT_NEAR(rows[4][8], std::exp(-0.5 * std::pow(15.0 * M_PI / 180.0, 2)), 0.01);
    EXPECT_NEAR(rows[7][8], 0.9, 0.01);
    EXPECT_GT(fs::file_size(out + "/tolerance.png"), 10000U);
    const nlohmann::json report = readSummary(out).at("report");
    EXPECT_NEAR(report.at("kelvinRms").get<double>(), 0.5 * rows[6][4], 0.1 * rows[6][4]);
    EXPECT_NEAR(report.at("kelvinLevel").get<double>(), 1.0, 0.02);
}

TEST(SolveTolerance, OptionsThatAreWrongAreRefused)
{
    EXPECT_NE(shell(kSolve + "--tolerance-dead 0.1 --out " + folder("needs")).code, 0);
    const Outcome outcome =
        shell(kSolve + "--tolerance --tolerance-dead 2 --out " + folder("range"));
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.output.find("dead is 2"), std::string::npos) << outcome.output;
}

TEST(SolveTolerance, DeadTransducersAreWrittenAsSilent)
{
    const std::string out = folder("dead");
    const Outcome outcome = shell(kSolve + "--dead 17,400-410 --weak 3:0.5 --cycle 3 --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    for (const char* name : {"/drive_01.csv", "/drive_02.csv", "/drive_03.csv"})
    {
        const auto drive = readCsv(out + name);
        ASSERT_EQ(drive.size(), 3984U);
        for (std::size_t i = 0; i < drive.size(); ++i)
            EXPECT_EQ(drive[i].back() == 0.0, i == 17 || (i >= 400 && i <= 410)) << i;
    }
    const Outcome wrong = shell(kSolve + "--dead 3984 --out " + out);
    EXPECT_EQ(wrong.code, 2);
    EXPECT_NE(wrong.output.find("dead has 3984; the array has 3984 transducers, 0 to 3983"),
              std::string::npos)
        << wrong.output;
}
