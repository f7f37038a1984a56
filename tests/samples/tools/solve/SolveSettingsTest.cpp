// midair-solve's options come from the table that scenes have, too.
#include "haptics/sequence/FieldSettings.h"
#include "tests/samples/Shell.h"

#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

const std::string kProgram = MIDAIR_BIN "/midair-solve";
const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";

} // namespace

TEST(SolveSettings, AreThoseOfAnyField)
{
    const std::string help = shell(kProgram + " --help").output;
    int known = 0;
    for (const auto& row : midair::haptics::fieldSettings().rows())
        known += help.find(row.help) != std::string::npos ? 1 : 0;
    EXPECT_EQ(known, static_cast<int>(midair::haptics::fieldSettings().rows().size()) - 4) << help;

    const std::string out = testing::TempDir() + "midair-solve-settings";
    const auto solved = [&](const std::string& options)
    {
        const Outcome outcome =
            shell(kProgram + " " + kStar + " --size 0.08 " + options + " --out " + out);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        std::ifstream file(out + "/summary.json");
        return nlohmann::json::parse(file);
    };
    const auto plain = solved("");
    EXPECT_GT(plain.at("report").at("iterations").get<int>(), 5);
    const auto hasty = solved("--max-iterations 1 --rms-tolerance 0");
    EXPECT_LT(hasty.at("report").at("iterations").get<int>(), 5);
    EXPECT_GT(hasty.at("report").at("rms").get<double>(),
              plain.at("report").at("rms").get<double>());
    EXPECT_LE(solved("--max-points 5").at("report").at("points").get<int>(), 5);
    EXPECT_GT(solved("--air-pressure 60000").at("attenuation_Np_m"), plain.at("attenuation_Np_m"));
    solved("--no-phase-only");
    std::set<std::string> duties;
    std::ifstream drive(out + "/drive.csv");
    std::string line;
    std::getline(drive, line);
    ASSERT_EQ(line.substr(line.rfind(',') + 1), "duty_level");
    while (std::getline(drive, line))
        duties.insert(line.substr(line.rfind(',') + 1));
    EXPECT_GT(duties.size(), 1U);
    const Outcome wrong = shell(kProgram + " " + kStar + " --lambda strong --out " + out);
    EXPECT_NE(wrong.code, 0);
    EXPECT_NE(wrong.output.find("--lambda: is \"strong\", should be a number, at least 0"),
              std::string::npos)
        << wrong.output;
}

TEST(SolveSettings, NumbersHaveUnits)
{
    const std::string solve = kProgram + " " + kStar + " --array board --out " +
                              testing::TempDir() + "midair-solve-units ";
    // The lines that say how many points there are and what the cap does.
    const auto result = [](const std::string& output)
    {
        std::istringstream lines(output);
        std::string kept;
        for (std::string line; std::getline(lines, line);)
            if (line.rfind("points", 0) == 0 || line.rfind("cap", 0) == 0) kept += line + "\n";
        return kept;
    };
    const Outcome plain =
        shell(solve + "--size 0.08 --position 0 0 0.15 --spacing 0.012 --max-pressure 800");
    const Outcome units =
        shell(solve + "--size 8cm --position 0 0 15cm --spacing '12 mm' --max-pressure '0.8 kPa'");
    EXPECT_EQ(plain.code, 0) << plain.output;
    EXPECT_EQ(units.code, 0) << units.output;
    EXPECT_EQ(result(units.output), result(plain.output));
    EXPECT_NE(result(plain.output).find("cap"), std::string::npos) << plain.output;
    for (const char* wrong : {"--size 8s",
                              "--size eight",
                              "--pressure 500,0",
                              "--pressure nan",
                              "--max-pressure '800 mm'",
                              "--max-pressure '1e99 Pa'"})
    {
        const Outcome refused = shell(solve + wrong);
        EXPECT_NE(refused.code, 0) << wrong;
        EXPECT_NE(refused.output.find("should be a number"), std::string::npos) << refused.output;
    }
}
