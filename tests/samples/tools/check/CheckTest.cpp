// Runs the built program as a user would, on the scenes of the gallery and on scenes with faults.

#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

const std::string kProgram = MIDAIR_BIN "/midair-check";
const std::string kScenes = MIDAIR_ROOT "/samples/scenes/";

/// Runs midair-check with an environment of no grants.
Outcome check(const std::string& arguments, const std::string& variables = "")
{
    return shell("env OSG_MIDAIR_GRANTS= XDG_CONFIG_HOME=/nonexistent " + variables + " " +
                 kProgram + " " + arguments);
}

std::string sceneFile(const std::string& name, const std::string& text)
{
    const std::string path = testing::TempDir() + "midair-check-" + name + ".osgt";
    std::ofstream(path) << "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n" << text;
    return path;
}

/// A ball named "ball" below a HapticScene with \a settings, the ball's own properties \a of.
std::string ballScene(const std::string& settings, const std::string& of, double x = 0.0)
{
    return "osgMidair::HapticScene { UniqueID 1 Name \"test\" Children 1 {\n"
           "  osgMidair::HapticSurface { UniqueID 2\n    Name \"ball\" Children 1 {\n"
           "    osg::ShapeDrawable { UniqueID 3 Shape TRUE { osg::Sphere { UniqueID 4 Center " +
           std::to_string(x) + " 0 0 Radius 0.01 } } }\n  } FormatVersion 1 " + of +
           " }\n} FormatVersion 1 " + settings + " }\n";
}

nlohmann::json
checkedJson(const std::string& arguments, int code, const std::string& variables = "")
{
    const Outcome outcome = check(arguments + " --json --frames 2", variables);
    EXPECT_EQ(outcome.code, code) << outcome.output;
    const nlohmann::json json = nlohmann::json::parse(outcome.output, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << outcome.output;
    return json;
}

bool hasMessage(const nlohmann::json& messages, const std::string& code)
{
    for (const nlohmann::json& message : messages)
        if (message["code"] == code) return true;
    return false;
}

} // namespace

TEST(MidairCheck, TheGalleryIsFeltAsItAsksFor)
{
    int scenes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(kScenes))
    {
        if (entry.path().extension() != ".osgt") continue;
        ++scenes;
        const Outcome outcome = check(entry.path().string());
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_EQ(outcome.output.find("OK: " + entry.path().string() + ": "), 0u) << outcome.output;
        EXPECT_LT(std::filesystem::file_size(entry.path()), 2000u) << "the gallery's are small";
    }
    EXPECT_GE(scenes, 9);
}

TEST(MidairCheck, SaysWhatIsFeltAndWhere)
{
    const std::string file =
        sceneFile("felt", ballScene("Array \"octagon\"", "Pressure 500 PressureUnit PASCAL", 0.02));
    const nlohmann::json json = checkedJson(file, 0);
    ASSERT_EQ(json["scenes"].size(), 1u);
    const nlohmann::json& scene = json["scenes"][0];
    EXPECT_EQ(scene["array"]["transducers"], 3984);
    EXPECT_EQ(scene["state"], "playing");
    ASSERT_EQ(scene["objects"].size(), 1u);
    const nlohmann::json& ball = scene["objects"][0];
    EXPECT_EQ(ball["path"], "HapticScene 'test'/HapticSurface 'ball'");
    EXPECT_GT(ball["points"], 5);
    EXPECT_EQ(ball["feltFrames"], 2);
    EXPECT_NEAR(ball["played_Pa"]["mean"], 500.0, 5.0);
    EXPECT_NEAR(ball["centre_m"][0], 0.02, 0.003);
    EXPECT_NEAR(ball["size_m"][2], 0.02, 0.004);
}

TEST(MidairCheck, OpensNoDeviceWhateverTheUserGrants)
{
    const std::string file = sceneFile("usb", ballScene("Array \"octagon\" Device \"usb:\"", ""));
    nlohmann::json json = checkedJson(file, 1);
    EXPECT_EQ(json["scenes"][0]["device"]["asked"], "usb:");
    EXPECT_EQ(json["scenes"][0]["device"]["granted"], "sim:");
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "grants.refused"));
    const std::string recording = testing::TempDir() + "midair-check-must-not-be.bin";
    std::filesystem::remove(recording);
    json = checkedJson(file, 0, "OSG_MIDAIR_DEVICE=record:" + recording);
    EXPECT_EQ(json["scenes"][0]["device"]["granted"], "record:" + recording);
    EXPECT_EQ(json["scenes"][0]["deviceStatus"].get<std::string>().find("sim:"), 0u);
    EXPECT_FALSE(std::filesystem::exists(recording));
    json = checkedJson("-O \"hands=openxr:\" " + file, 1);
    EXPECT_EQ(json["scenes"][0]["hands"]["granted"], "openxr:");
    EXPECT_FALSE(hasMessage(json["scenes"][0]["messages"], "hands.source"));
}

TEST(MidairCheck, TellsNamesOfDevicesAndHandsThatAreNone)
{
    const std::string file = kScenes + "star.osgt";
    nlohmann::json json = checkedJson("-O device=smi: " + file, 1);
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "device.open"));
    json = checkedJson("-O hands=nonsense " + file, 1);
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "hands.open"));
}

TEST(MidairCheck, EndsWithOneWhereSomethingIsNotFeltAsAskedFor)
{
    const std::string array = "Array \"octagon\" ";
    nlohmann::json json = checkedJson(sceneFile("far", ballScene(array, "", 30.0)), 1);
    EXPECT_TRUE(json["scenes"][0]["objects"][0]["unreachable"]);
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "object.unreachable"));
    json = checkedJson(
        sceneFile("capped",
                  ballScene(array + "MaxPressure 200", "Pressure 500 PressureUnit PASCAL")),
        1);
    EXPECT_EQ(json["scenes"][0]["maxPressure_Pa"], 200.0);
    EXPECT_LT(json["scenes"][0]["objects"][0]["share"]["mean"], 0.5);
    EXPECT_EQ(json["scenes"][0]["objects"][0]["faults"].size(), 1u);
    json = checkedJson(sceneFile("silenced", ballScene(array + "MaxPressure -8", "")), 1);
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "settings.silenced"));
    json =
        checkedJson(sceneFile("strong", ballScene(array, "Pressure 90000 PressureUnit PASCAL")), 1);
    EXPECT_LT(json["scenes"][0]["objects"][0]["share"]["mean"], 0.9);
}

TEST(MidairCheck, SaysInWhichLineOfTheFileANodeIs)
{
    const std::string file = sceneFile("line", ballScene("Array \"octagon\"", "Spacing 7", 30.0));
    const Outcome outcome = check(file + " --frames 1");
    EXPECT_EQ(outcome.code, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("line.osgt:8: HapticSurface 'ball': Spacing is \"7\", should be"),
              std::string::npos)
        << outcome.output;
    EXPECT_NE(outcome.output.find("[" + file + ":6]"), std::string::npos) << outcome.output;
}

TEST(MidairCheck, NamesATextOfAFontWithoutOutlines)
{
    const std::string file = sceneFile(
        "text",
        "osgMidair::HapticScene { UniqueID 1 Children 1 {\n"
        "  osgMidair::HapticSurface { UniqueID 2 Name \"label\" Children 2 {\n"
        "    osgText::Text { UniqueID 3 Name \"words\" Text TRUE \"Hi\" }\n"
        "    osg::ShapeDrawable { UniqueID 4 Shape TRUE { osg::Box { UniqueID 5\n"
        "      HalfLengths 0.01 0.01 0.01 } } }\n  } }\n} FormatVersion 1 Array \"octagon\" }\n");
    const Outcome outcome = check(file + " --frames 2");
    EXPECT_EQ(outcome.code, 1) << outcome.output;
    EXPECT_NE(
        outcome.output.find("warning object.geometry: HapticScene/HapticSurface 'label': Text "
                            "'words' is text of which 2 characters have no outline in their font "
                            "(a TrueType font has them); they can't be felt"),
        std::string::npos)
        << outcome.output;
}

TEST(MidairCheck, PlaysModelsAndSettings)
{
    const std::string star = MIDAIR_ROOT "/samples/models/star.obj";
    nlohmann::json json = checkedJson(star, 0);
    EXPECT_NE(json["wrapped"], "");
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "scene.unmarked")) << "all of it is felt";
    EXPECT_EQ(json["scenes"][0]["objects"][0]["name"], "star.obj");
    json = checkedJson(star + ".haptic -O \"size=0.06\"", 0);
    EXPECT_EQ(json["wrapped"], "");
    EXPECT_NEAR(json["scenes"][0]["objects"][0]["size_m"][0], 0.06, 1e-3);
    const std::string settings = testing::TempDir() + "midair-check.haptic";
    std::ofstream(settings) << "maxPressure = 300\npressure = 20 Pa\ndevice = usb:\n";
    json = checkedJson("--device " + settings + " " + star, 0);
    EXPECT_EQ(json["scenes"][0]["device"]["granted"], "usb:"); // the user names it
    EXPECT_EQ(json["scenes"][0]["deviceStatus"].get<std::string>().find("sim:"), 0u);
    EXPECT_EQ(json["scenes"][0]["maxPressure_Pa"], 300.0);
    EXPECT_EQ(json["scenes"][0]["objects"][0]["asked"]["unit"], "Pa");
}

TEST(MidairCheck, TellsThatObjFilesAreTurned)
{
    const std::string star = MIDAIR_ROOT "/samples/models/star.obj";
    const auto isTold = [](const std::string& arguments)
    { return check(arguments).output.find("y is up in OBJ files") != std::string::npos; };
    EXPECT_TRUE(isTold(star));
    EXPECT_TRUE(isTold(star + ".haptic -O size=0.08"));
    EXPECT_FALSE(isTold(star + " -O noRotation"));
    EXPECT_FALSE(isTold(kScenes + "star.osgt"));
}

TEST(MidairCheck, AHiddenMarkIsOneAndNothingElseIsFelt)
{
    const std::string file =
        sceneFile("hidden",
                  "osg::Group { UniqueID 1 Name \"room\" Children 2 {\n"
                  "  osg::ShapeDrawable { UniqueID 2 Shape TRUE { osg::Sphere { UniqueID 3 Radius "
                  "0.01 } } }\n"
                  "  osg::Switch { UniqueID 4 Name \"doors\" Children 1 {\n"
                  "    osg::Group { UniqueID 6 Name \"mug\" UserDataContainer TRUE {\n"
                  "      osg::DefaultUserDataContainer { UniqueID 7 UDC_Descriptions 1 { "
                  "\"haptic\" } } } } }\n"
                  "    ValueList 1 { FALSE } }\n} }\n");
    const nlohmann::json json = checkedJson(file, 1);
    EXPECT_TRUE(json["scenes"][0]["objects"].empty()) << json.dump(1);
    EXPECT_EQ(json["scenes"][0]["points"], 0);
    EXPECT_FALSE(hasMessage(json["scenes"][0]["messages"], "scene.unmarked"));
}

TEST(MidairCheck, AnObjectsLineSaysTheCauseOfItsMessage)
{
    const std::string array = "Array \"octagon\" ";
    std::string scene = ballScene(array, "");
    const std::string ball = "Radius 0.01";
    scene.replace(scene.find(ball), ball.size(), "Radius 0.5");
    nlohmann::json json = checkedJson(sceneFile("large", scene), 1);
    const nlohmann::json large = json["scenes"][0]["objects"][0]["faults"];
    ASSERT_EQ(large.size(), 1u) << large.dump();
    EXPECT_NE(large[0].get<std::string>().find(", larger than the workspace of "),
              std::string::npos)
        << large;
    EXPECT_NE(large[0].get<std::string>().find("; size=0.08 fits"), std::string::npos) << large;
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "object.large"));
    EXPECT_FALSE(hasMessage(json["scenes"][0]["messages"], "points.budget"));

    json = checkedJson(sceneFile("nothing",
                                 "osgMidair::HapticScene { UniqueID 1 Children 1 {\n"
                                 "  osgMidair::HapticSurface { UniqueID 2 Name \"air\" } } " +
                                     array + "}\n"),
                       1);
    EXPECT_EQ(json["scenes"][0]["objects"][0]["faults"].dump(),
              "[\"has no drawables below it; it can't be felt\"]");
    json =
        checkedJson(sceneFile("empty", "osgMidair::HapticScene { UniqueID 1 " + array + "}\n"), 1);
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "scene.empty"));
}

TEST(MidairCheck, SaysWhyNothingIsFelt)
{
    const auto why = [](const std::string& name, const std::string& text)
    {
        const nlohmann::json json = checkedJson(sceneFile(name, text), 1);
        return json["scenes"].empty() ? std::string("no scene")
                                      : json["scenes"][0]["unfelt"].get<std::string>();
    };
    EXPECT_EQ(why("off", ballScene("Enabled FALSE", "")), "the scene is not enabled");
    EXPECT_EQ(why("hidden", ballScene("NodeMask 0x0", "")), "the scene is hidden by its node mask");
    EXPECT_NE(why("shown", ballScene("", "NodeMask 0x0")).find("hidden"), std::string::npos);
    const nlohmann::json hidden = checkedJson(sceneFile("shown", ballScene("", "NodeMask 0x0")), 1);
    EXPECT_TRUE(hasMessage(hidden["scenes"][0]["messages"], "object.hidden"));
}

// Contacts go by the clock: two seconds of the recording take two seconds.
TEST(MidairCheck, PlaysARecordingOfHandsThatTouch)
{
    const std::string star = kScenes + "star.osgt -O 'render=contact hands=";
    const std::string recorded = "recorded:" MIDAIR_ROOT "/samples/hands/star.csv'";
    const Outcome touched = check(star + recorded + " --frames 120");
    EXPECT_EQ(touched.code, 0) << touched.output;
    EXPECT_NE(touched.output.find("it is felt in "), std::string::npos) << touched.output;
    const Outcome before = check(star + recorded + " --frames 2");
    EXPECT_EQ(before.code, 1) << before.output;
    EXPECT_NE(before.output.find("no recorded hand"), std::string::npos) << before.output;
    const Outcome tracked = check(star + "openxr:'");
    EXPECT_EQ(tracked.code, 0) << tracked.output;
    EXPECT_EQ(tracked.output.find("WARNING: "), 0u) << tracked.output;
    EXPECT_NE(tracked.output.find("-O hands=recorded:FILE"), std::string::npos) << tracked.output;
}

TEST(MidairCheck, SaysTheRootCauseFirstAndALineAnObject)
{
    const Outcome outcome =
        check(kScenes + "star.osgt -O 'array=none.json render=contact hands=recorded:" MIDAIR_ROOT
                        "/samples/hands/star.csv' --frames 2");
    EXPECT_EQ(outcome.code, 1);
    const std::string first = outcome.output.substr(0, outcome.output.find('\n'));
    EXPECT_EQ(first.find("PROBLEM: " + kScenes + "star.osgt: "), 0u) << first;
    EXPECT_NE(first.find("none.json"), std::string::npos) << first;
    EXPECT_NE(
        outcome.output.find("\n  PROBLEM  HapticScene/HapticSurface 'star': nothing is played\n"),
        std::string::npos)
        << outcome.output;
    EXPECT_EQ(outcome.output.find("no recorded hand"), std::string::npos) << outcome.output;
}

// 5 Pa are played as they are asked for, and nobody feels them.
TEST(MidairCheck, WarnsOfWhatIsTooWeakToFeel)
{
    const std::string weak = sceneFile("weak", ballScene("", "Pressure 5 PressureUnit PASCAL"));
    const nlohmann::json json = checkedJson(weak, 0);
    EXPECT_EQ(json["verdict"], "WARNING");
    EXPECT_NE(json["because"].get<std::string>().find("it is too weak to feel: "),
              std::string::npos)
        << json["because"];
    EXPECT_EQ(checkedJson(sceneFile("strong", ballScene("", "")), 0)["verdict"], "OK");
}

TEST(MidairCheck, WarnsWhereAllObjectsAreSwitchedOff)
{
    const nlohmann::json json = checkedJson(sceneFile("off", ballScene("", "Enabled FALSE")), 0);
    EXPECT_EQ(json["verdict"], "WARNING");
    EXPECT_NE(json["because"].get<std::string>().find("switched off"), std::string::npos);
}

// A square of 50 mm at coordinates of a map, which single precision rounds to 31 mm.
TEST(MidairCheck, ProposesTheSizeThatAModelHas)
{
    const std::string path = testing::TempDir() + "midair-check-map.obj";
    std::ofstream(path) << "v 500000.00 5400000.00 0\nv 500000.05 5400000.00 0\n"
                           "v 500000.05 5400000.05 0\nv 500000.00 5400000.05 0\nf 1 2 3 4\n";
    const std::string remedy = checkedJson(path, 1)["remedy"];
    EXPECT_NE(remedy.find("size=0.05\""), std::string::npos) << remedy;
}

TEST(MidairCheck, SaysWhatAFingertipGets)
{
    const nlohmann::json json = checkedJson(sceneFile("force", ballScene("", "")), 0);
    const nlohmann::json& object = json["scenes"][0]["objects"][0];
    EXPECT_GT(object["fingertip_N"], 1e-3) << object;
    EXPECT_LT(object["fingertip_N"], 0.1) << object;
    const double force_N = object["fingertip_N"];
    EXPECT_EQ(object["feeling"],
              force_N < 15e-3   ? "faint"
              : force_N < 40e-3 ? "clear"
                                : "strong")
        << object;
}

// The field of a frame is waited for, but not where there can be none.
TEST(MidairCheck, WaitsForNoFieldWithoutAnArray)
{
    const nlohmann::json json =
        checkedJson(kScenes + "star.osgt -O array=none.json --wait 3600", 1);
    EXPECT_EQ(json["scenes"][0]["state"], "closed");
}

TEST(MidairCheck, SaysThatASilencedObjectPlaysNothing)
{
    const std::string file = sceneFile("slip", ballScene("", "Presure 500"));
    const Outcome outcome = check(file + " --frames 2");
    EXPECT_EQ(outcome.code, 1);
    for (const char* told :
         {"felt in 0 of 2 frames", "plays     nothing", "pressure  an invalid value"})
        EXPECT_NE(outcome.output.find(told), std::string::npos) << told << outcome.output;
    EXPECT_EQ(outcome.output.find("100.0 %"), std::string::npos) << outcome.output;
    const nlohmann::json object = checkedJson(file, 1)["scenes"][0]["objects"][0];
    EXPECT_EQ(object["share"]["mean"], 0.0);
}

TEST(MidairCheck, TheFieldsLevelIsWhatThePlayedAmplitudeLeaves)
{
    const std::string file = sceneFile("lowered", ballScene("", ""));
    const auto level = [&file](const std::string& variables)
    { return checkedJson(file, 0, variables)["scenes"][0]; };
    const nlohmann::json full = level("");
    const nlohmann::json fifth = level("OSG_MIDAIR_MAX_AMPLITUDE=0.2");
    EXPECT_LT(fifth["level_Pa"].get<double>(), 0.25 * full["level_Pa"].get<double>());
    EXPECT_NEAR(fifth["level_Pa"].get<double>(),
                fifth["objects"][0]["played_Pa"]["mean"].get<double>(),
                0.01 * fifth["level_Pa"].get<double>());
}

TEST(MidairCheck, WarnsOfAPressureWithoutItsUnit)
{
    const nlohmann::json json = checkedJson(sceneFile("loud", ballScene("", "Pressure 400")), 0);
    EXPECT_EQ(json["verdict"], "WARNING");
    const std::string warning = json["scenes"][0]["objects"][0]["warnings"][0];
    EXPECT_NE(warning.find("400 Pa"), std::string::npos) << warning;
    EXPECT_EQ(checkedJson(sceneFile("two", ballScene("", "Pressure 2")), 0)["verdict"], "OK");
}

TEST(MidairCheck, AMisspeltTagIsTold)
{
    const std::string file = sceneFile(
        "misspelt",
        "osg::Group { UniqueID 1 Name \"mug\" UserDataContainer TRUE {\n"
        "  osg::DefaultUserDataContainer { UniqueID 2 UDC_Descriptions 1 { \"haptik=1\" } } }\n"
        "  Children 1 { osg::ShapeDrawable { UniqueID 3 Shape TRUE {\n"
        "    osg::Sphere { UniqueID 4 Radius 0.01 } } } } }\n");
    const std::string because = checkedJson(file, 1)["because"];
    for (const char* said : {"haptik", "did you mean haptic?"})
        EXPECT_NE(because.find(said), std::string::npos) << because;
}

TEST(MidairCheck, ReadsWhatAPagerWouldAndSaysWhatItDoesNot)
{
    const std::string tile = sceneFile(
        "tile",
        "osg::Group { UniqueID 1 Name \"mug\" UserDataContainer TRUE {\n"
        "  osg::DefaultUserDataContainer { UniqueID 2 UDC_Descriptions 1 { \"haptic\" } } }\n"
        "  Children 1 { osg::ShapeDrawable { UniqueID 3 Shape TRUE {\n"
        "    osg::Sphere { UniqueID 4 Radius 0.01 } } } } }\n");
    const auto paged = [](const std::string& name)
    {
        return "osg::PagedLOD { UniqueID 1 Name \"page\" RangeList 1 { 0 1e6 }\n"
               "  RangeDataList 1 { \"" +
               name + "\" }\n  PriorityList 1 { 0 1 } }\n";
    };
    nlohmann::json json = checkedJson(sceneFile("paged", paged(tile)), 0);
    ASSERT_EQ(json["scenes"][0]["objects"].size(), 1u) << json.dump(1);
    EXPECT_EQ(json["scenes"][0]["objects"][0]["name"], "mug");
    EXPECT_TRUE(json["reading"].empty()) << json["reading"];
    json = checkedJson(sceneFile("unpaged", paged("nowhere.osgt")), 1);
    EXPECT_TRUE(json["scenes"][0]["objects"].empty());
    EXPECT_NE(json["reading"].dump().find("nowhere.osgt\\\", which can't be read"),
              std::string::npos)
        << json["reading"];
    EXPECT_TRUE(hasMessage(json["scenes"][0]["messages"], "scene.incomplete"));
    json = checkedJson(
        sceneFile("endless", paged(testing::TempDir() + "midair-check-endless.osgt")), 1);
    EXPECT_NE(json["reading"].dump().find("only the first 256 files"), std::string::npos)
        << "a file that names itself";
}

TEST(MidairCheck, EndsWithTwoWhereNothingCanBeRead)
{
    Outcome outcome = check("/nonexistent.osgt");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.output.find("midair-check: can't read \"/nonexistent.osgt\": "), 0u)
        << outcome.output;
    EXPECT_EQ(check("").code, 2);
    EXPECT_EQ(check("--frames 0 x.osgt").code, 2);
    outcome = check("--help");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.output.find("--json"), std::string::npos);
}
