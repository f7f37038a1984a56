// Limits, switches and pressures as text, from options, tags, settings files and variables: with
// units and in any spelling they are understood, and where they aren't nothing is played.
#include "plugin/settings/Assignments.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticDevice>

#include <osg/ApplicationUsage>
#include <osg/ComputeBoundsVisitor>
#include <osgDB/ReadFile>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

HapticSettings fromVariable(const char* name, const char* value)
{
    setenv(name, value, 1);
    std::vector<std::string> errors;
    HapticSettings settings = Environment::restrict(Environment::replace(HapticSettings(), errors));
    unsetenv(name);
    settings.repair();
    return settings;
}

HapticProperty fromTag(const std::string& text)
{
    HapticProperty property;
    std::vector<std::string> errors;
    property.parse(text, errors);
    EXPECT_EQ(errors.empty(), property.whySilenced.empty()) << text;
    property.repair();
    return property;
}

/// Reads a model with options as of a command line; the scene's settings and its surface.
osg::ref_ptr<HapticScene> fromOptions(const std::string& text)
{
    findPlugins();
    const osg::ref_ptr<osgDB::Options> options = new osgDB::Options(text);
    const osg::ref_ptr<osg::Node> node =
        osgDB::readRefNodeFile(MIDAIR_ROOT "/samples/models/star.obj.haptic", options);
    return dynamic_cast<HapticScene*>(node.get());
}

HapticSurface& surfaceOf(HapticScene& scene)
{
    return dynamic_cast<HapticSurface&>(*scene.getChild(0));
}

bool isSilenced(HapticScene& scene)
{
    return scene.getSettings().isSilenced || !surfaceOf(scene).getProperty().whySilenced.empty();
}

} // namespace

TEST(UnclearText, InAVariableSilences)
{
    EXPECT_EQ(fromVariable("OSG_MIDAIR_MAX_PRESSURE", "800 Pa").maxPressure, 800.0);
    EXPECT_EQ(fromVariable("OSG_MIDAIR_MAX_PRESSURE", "0.8kPa").maxPressure, 800.0);
    EXPECT_EQ(fromVariable("OSG_MIDAIR_MAX_AMPLITUDE", "30 %").maxAmplitude, 0.3);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_ENABLED", "FALSE").enabled);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_ENABLED", "No").enabled);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_ENABLED", "no").isSilenced);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_MAX_PRESSURE", "800 Pa").isSilenced);
    for (const char* wrong :
         {"1e99 Pa", "1e99", "NaN", "inf", "500,0", "800 mm", "-1", "eight", "800 Pa Pa"})
        EXPECT_TRUE(fromVariable("OSG_MIDAIR_MAX_PRESSURE", wrong).isSilenced) << wrong;
    for (const char* wrong : {"flase", "2", "FALSE FALSE"})
        EXPECT_TRUE(fromVariable("OSG_MIDAIR_ENABLED", wrong).isSilenced) << wrong;
}

TEST(UnclearText, InTheNameOfAVariableSilences)
{
    EXPECT_TRUE(fromVariable("OSG_MIDAIR_MAX_PRESURE", "800").isSilenced);
    EXPECT_TRUE(fromVariable("OSG_MIDAIR_ENABELD", "false").isSilenced);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_SOLVR", "gs").isSilenced);
    EXPECT_FALSE(fromVariable("OSG_MIDAIR_QUIRK", "1").isSilenced);
    setenv("OSG_MIDAIR_SOLVR", "gs", 1);
    std::vector<std::string> errors;
    Environment::restrict(Environment::replace(HapticSettings(), errors));
    unsetenv("OSG_MIDAIR_SOLVR");
    EXPECT_EQ(
        errors,
        std::vector<std::string>{"OSG_MIDAIR_SOLVR is an unknown variable (did you mean SOLVER?)"});
}

TEST(UnclearText, EachVariableThatTheHelpListsIsOne)
{
    int listed = 0;
    for (const auto& [option, text] :
         osg::ApplicationUsage::instance()->getEnvironmentalVariables())
    {
        const std::string name = option.substr(0, option.find(' '));
        if (name.rfind("OSG_MIDAIR_", 0) != 0) continue;
        ++listed;
        const bool wasThere = std::getenv(name.c_str()) != nullptr;
        if (!wasThere) setenv(name.c_str(), "x", 1);
        std::vector<std::string> errors;
        Environment::restrict(Environment::replace(HapticSettings(), errors));
        if (!wasThere) unsetenv(name.c_str());
        for (const std::string& error : errors)
            EXPECT_EQ(error.find("is an unknown variable"), std::string::npos) << error;
    }
    EXPECT_GE(listed, 23);
}

TEST(UnclearText, InATagSilences)
{
    const HapticProperty right = fromTag("pressure=0.5 kPa; spacing=9mm; sampling=Edges");
    EXPECT_EQ(right.pressure, 500.0);
    EXPECT_EQ(right.pressureUnit, HapticProperty::PASCAL);
    EXPECT_EQ(right.spacing, 0.009);
    EXPECT_EQ(right.sampling, HapticProperty::EDGES);
    EXPECT_FALSE(fromTag("FALSE").enabled);
    const HapticProperty order = fromTag("unit=Pa; pressure=500");
    EXPECT_EQ(order.pressure, 500.0);
    EXPECT_EQ(order.pressureUnit, HapticProperty::PASCAL) << "a pressure keeps the unit before it";
    EXPECT_EQ(fromTag("pressure=50%").pressure, 0.5);
    for (const char* wrong : {"pressure=500,0 Pa",
                              "pressure=500,0",
                              "pressure=1e99 Pa",
                              "pressure=nan",
                              "pressure=500 mm",
                              "presure=500 Pa",
                              "enabeld=false",
                              "flase",
                              "quirk=3"})
        EXPECT_FALSE(fromTag(wrong).whySilenced.empty()) << wrong;
    HapticProperty harmless;
    std::vector<std::string> errors;
    harmless.parse("samplng=edges; sampling=egdes", errors);
    EXPECT_TRUE(harmless.whySilenced.empty());
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_EQ(errors[0], "unknown option \"samplng\" (did you mean sampling?)");
    EXPECT_EQ(
        errors[1],
        "sampling is \"egdes\", should be one of surface, edges, vertices (did you mean edges?)");
}

TEST(UnclearText, InOptionsSilences)
{
    Notices notices;
    const auto right =
        fromOptions("size=8cm position=\"0 0 12 cm\" pressure=500 Pa, maxPressure=0.8 kPa");
    ASSERT_NE(right, nullptr);
    EXPECT_EQ(notices.text(), "");
    EXPECT_FALSE(isSilenced(*right));
    EXPECT_EQ(right->getMaxPressure(), 800.0);
    EXPECT_EQ(surfaceOf(*right).getPressure(), 500.0);
    osg::ComputeBoundsVisitor bounds;
    right->accept(bounds);
    const osg::BoundingBox& box = bounds.getBoundingBox();
    EXPECT_NEAR(box.xMax() - box.xMin(), 0.08, 1e-6) << "float vertices";
    EXPECT_NEAR(box.center().z(), 0.12, 1e-6);
    for (const char* wrong : {"pressure=500,0 Pa",
                              "maxPressure=500,0",
                              "maxPressure=800 mm",
                              "maxPresure=800 Pa",
                              "enabled=flase",
                              "maxPressure 800"})
    {
        const auto scene = fromOptions(wrong);
        ASSERT_NE(scene, nullptr);
        EXPECT_TRUE(isSilenced(*scene)) << wrong;
        EXPECT_NE(surfaceOf(*scene).getPressure(), 500.0) << wrong;
    }
    const auto others = fromOptions("noRotation dds_flip Compressor=zlib smell=4");
    ASSERT_NE(others, nullptr);
    EXPECT_FALSE(isSilenced(*others)) << "options of other plugins";
}

TEST(UnclearText, InAFileOfSettingsSilences)
{
    findPlugins();
    const auto folder =
        std::filesystem::temp_directory_path() / ("midair-unclear-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    const std::string file = (folder / "desk.haptic").string();
    const auto read = [&file](const std::string& text)
    {
        std::ofstream(file) << text;
        return osgDB::readRefFile<HapticDevice>(file);
    };
    for (const char* wrong :
         {"maxPressure 800\n", "maxPresure = 800\n", "quirk = 3\n", "maxPressure = 1,5 kPa\n"})
    {
        Notices notices;
        const osg::ref_ptr<HapticDevice> device = read(wrong);
        ASSERT_TRUE(device) << wrong;
        EXPECT_TRUE(device->getSettings().isSilenced) << wrong;
        EXPECT_FALSE(device->getSettings().whySilenced.empty()) << wrong;
        EXPECT_NE(notices.text().find("; nothing is played"), std::string::npos) << notices.text();
    }
    Notices notices;
    const osg::ref_ptr<HapticDevice> right =
        read("maxPressure = 1.5 kPa # loud\nEnabled = x\nenabled = Yes\n");
    ASSERT_TRUE(right);
    EXPECT_EQ(right->getSettings().maxPressure, 1500.0);
    EXPECT_TRUE(right->getSettings().isSilenced) << "Enabled is no name, and may be enabled";
    std::filesystem::remove_all(folder);
}

TEST(UnclearText, InAFileOfSettingsIsToldWithItsLineAndTheNearestWord)
{
    findPlugins();
    const std::string file = testing::TempDir() + "midair-lines.haptic";
    std::ofstream(file) << "# a desk\nsampling = egdes\n\ncycle = -4 # one too few\n"
                           "pressure = -5 Pa\nspcing = 4 mm\n";
    Notices notices;
    const osg::ref_ptr<HapticDevice> device = osgDB::readRefFile<HapticDevice>(file);
    ASSERT_TRUE(device);
    for (const char* told : {"midair-lines.haptic:2: sampling is \"egdes\", should be one of "
                             "surface, edges, vertices (did you mean edges?)",
                             "midair-lines.haptic:4: cycle is \"-4\", should be",
                             "midair-lines.haptic:5: pressure is \"-5 Pa\", should be",
                             "midair-lines.haptic:6: unknown option \"spcing\" (did you mean "
                             "spacing?)"})
        EXPECT_NE(notices.text().find(told), std::string::npos) << told << "\n" << notices.text();
    EXPECT_TRUE(device->getSettings().isSilenced) << "a pressure that isn't known may be any";
    std::filesystem::remove(file);
}

TEST(Assignments, ACommaBetweenDigitsSeparatesNothing)
{
    std::string seen;
    for (const Assignment& one : assignmentsIn("a=1,5 b=2, c=3,d=4"))
        seen += one.name + "=" + one.value + "|";
    EXPECT_EQ(seen, "a=1,5|b=2|c=3|d=4|");
}

TEST(Assignments, KnowTheirLines)
{
    std::string seen;
    for (const Assignment& one : assignmentsIn("a=1 # one; b=2\n\n c=3; d=\"x\ny\"\r\ne=4"))
        seen += one.name + std::to_string(one.line) + " ";
    EXPECT_EQ(seen, "a1 c3 d3 e5 ");
}

TEST(Assignments, NumbersHaveUnits)
{
    double place[3] = {};
    EXPECT_TRUE(parseNumbers("0 5 12 cm", place, 3, "m"));
    EXPECT_EQ(place[1], 0.05);
    EXPECT_EQ(place[2], 0.12);
    EXPECT_TRUE(parseNumbers("0 5mm 0.2", place, 3, "m"));
    EXPECT_EQ(place[1], 0.005);
    EXPECT_EQ(place[2], 0.2);
    for (const char* wrong : {"0 0", "0 0 0 0", "0 0 1 s", "cm 0 0 1", "0 cm 0 1", "1,2,3"})
        EXPECT_FALSE(parseNumbers(wrong, place, 3, "m")) << wrong;
}

TEST(UnclearText, AWrongUnitOfAPressureIsAnsweredWithTheRightOne)
{
    osgMidair::HapticProperty property;
    std::string error;
    EXPECT_FALSE(property.set("pressure", "4000 Pascal", error));
    EXPECT_NE(error.find("4000 Pa;"), std::string::npos) << error;
    EXPECT_EQ(property.whySilenced, std::vector<std::string>{error});
}
