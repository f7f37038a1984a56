// Runs the built program as a user would.

#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;

const std::string kProgram = MIDAIR_BIN "/midair-paper-scenes";

std::string folder(const std::string& name)
{
    return testing::TempDir() + "midair-paper-scenes-" + name + std::to_string(::getpid());
}

} // namespace

TEST(PaperScenes, AreAllPlayed)
{
    const std::string out = folder("all");
    const Outcome run =
        shell(kProgram + " --headless --frames 180 --each 0.45 --pictures 2 --out " + out);
    ASSERT_EQ(run.code, 0) << run.output;
    nlohmann::json report;
    std::ifstream(out + "/report.json") >> report;
    const nlohmann::json& scene = report.at("scene");
    const std::pair<const char*, int> all[] = {{"focus", 1},
                                               {"line", 5},
                                               {"flat star", 11},
                                               {"star", 11},
                                               {"oblique line", 5},
                                               {"shifted line", 5}};
    for (const auto& [name, points] : all)
    {
        ASSERT_TRUE(scene.contains(name)) << name << "\n" << run.output;
        EXPECT_EQ(scene[name].at("points").get<int>(), points) << name;
        EXPECT_GT(scene[name].at("level_Pa").get<double>(), 500.0) << name;
        EXPECT_LT(scene[name].at("rms").get<double>(), 0.02) << name;
    }
    EXPECT_TRUE(fs::exists(out + "/paper-scenes_2.png"));
    fs::remove_all(out);
}

TEST(PaperScenes, OneStays)
{
    const std::string out = folder("one");
    const Outcome run =
        shell(kProgram + " --headless --frames 60 --each 0.1 --scene 3 --pictures 0 --out " + out);
    ASSERT_EQ(run.code, 0) << run.output;
    nlohmann::json report;
    std::ifstream(out + "/report.json") >> report;
    EXPECT_EQ(report.at("scene").size(), 1u) << report.dump();
    EXPECT_TRUE(report.at("scene").contains("flat star"));
    fs::remove_all(out);
}
