#include "engine-bridge/sensations/SensationTexts.h"

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/sensations/SensationLibrary.h"
#include "tests/haptics/sensation/Patterns.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using Attach = SensationProperties::Attach;

TEST(SensationTexts, AttachmentsAreAPlaceASurfaceOrAJoint)
{
    Attach attach = Attach::PLACE;
    int joint = -1;
    EXPECT_TRUE(readAttachment(" surface ", attach, joint));
    EXPECT_EQ(attach, Attach::SURFACE);
    EXPECT_TRUE(readAttachment("hand:index_tip", attach, joint));
    EXPECT_EQ(attach, Attach::HAND);
    EXPECT_EQ(joint, INDEX_TIP);
    EXPECT_TRUE(readAttachment("place", attach, joint));
    EXPECT_EQ(attach, Attach::PLACE);
    for (const char* wrong : {"", "hand", "hand:", "hand:index tip", "hand:nose", "palm"})
    {
        EXPECT_FALSE(readAttachment(wrong, attach, joint)) << wrong;
        EXPECT_NE(problemOfAttachment(wrong), "") << wrong;
    }
    EXPECT_NE(problemOfAttachment("hand:palms").find("hand:palm"), std::string::npos);
}

TEST(SensationTexts, ParametersAreNamesWithNumbers)
{
    std::vector<std::pair<std::string, double>> values;
    EXPECT_EQ(readParameters("strength = 0.4; size=3;", values), "");
    EXPECT_EQ(values,
              (std::vector<std::pair<std::string, double>>{{"strength", 0.4}, {"size", 3}}));
    EXPECT_EQ(readParameters("a=1&b=-2e-3", values), "");
    EXPECT_EQ(values.at(1).second, -2e-3);
    EXPECT_EQ(readParameters(parametersText(values), values), "");
    EXPECT_EQ(values.size(), 2u);
    for (const char* wrong : {"a", "a=", "=1", "a=x", "a=nan", "a=inf", "a=1; a=2", "a=1 b=2"})
    {
        EXPECT_NE(readParameters(wrong, values), "") << wrong;
        EXPECT_EQ(values.size(), 2u) << "they stay";
    }
    EXPECT_EQ(readParameters("", values), "");
    EXPECT_TRUE(values.empty());
}

TEST(SensationLibrary, ReadsClassicsFilesAndTextsOfFiles)
{
    ObjectSettings settings;
    EXPECT_FALSE(sensationOf(settings).properties.isMeant);
    settings.sensation = "circle?radius=20mm";
    const MadeSensation circle = sensationOf(settings);
    EXPECT_EQ(circle.problem, "");
    ASSERT_TRUE(circle.properties.pattern);
    EXPECT_EQ(sensationOf(settings).properties.pattern, circle.properties.pattern) << "read once";

    const std::string text =
        patterns::pattern({patterns::standard(0.0, patterns::coords(0, 0, 0))}).dump();
    settings.sensation = text;
    EXPECT_TRUE(sensationOf(settings).properties.pattern);

    const auto file = std::filesystem::temp_directory_path() / "library.adaptics";
    std::ofstream(file) << text;
    settings.sensation = file.string();
    const auto first = sensationOf(settings).properties.pattern;
    EXPECT_TRUE(first);
    std::ofstream(file) << "{}";
    std::filesystem::last_write_time(
        file, std::filesystem::last_write_time(file) + std::chrono::seconds(2));
    const MadeSensation broken = sensationOf(settings);
    EXPECT_TRUE(broken.properties.isMeant);
    EXPECT_FALSE(broken.properties.pattern) << "a changed file is read again";
    EXPECT_NE(broken.problem, "");
}

TEST(SensationLibrary, TellsOfParametersThatThePatternHasNot)
{
    ObjectSettings settings;
    settings.sensation = "circle?radius=20mm";
    settings.parameters = "radius=10; frequenzy=70";
    const MadeSensation made = sensationOf(settings);
    EXPECT_TRUE(made.properties.pattern) << "the others are set";
    EXPECT_NE(made.problem.find("frequenzy"), std::string::npos) << made.problem;
    EXPECT_NE(made.problem.find("frequency"), std::string::npos) << made.problem;
}
