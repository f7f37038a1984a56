// Runs the built program as a user would, on models as people bring them.

#include "tests/samples/Shell.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <tuple>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

const std::string kProgram = MIDAIR_BIN "/midair-check";

Outcome check(const std::string& arguments)
{
    return shell("env OSG_MIDAIR_GRANTS= XDG_CONFIG_HOME=/nonexistent " + kProgram + " " +
                 arguments);
}

nlohmann::json checkedJson(const std::string& arguments, int code)
{
    const Outcome outcome = check(arguments + " --json --frames 2");
    EXPECT_EQ(outcome.code, code) << outcome.output;
    const nlohmann::json json = nlohmann::json::parse(outcome.output, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << outcome.output;
    return json;
}

std::string modelFile(const std::string& name, const std::string& text)
{
    const std::string path = testing::TempDir() + "midair-check-" + name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
}

const std::string kPlate = "v -0.02 -0.02 0\nv 0.02 -0.02 0\nv 0.02 0.02 0\nv -0.02 0.02 0\n";

} // namespace

// Its verdict is about what is felt: materials and pictures that are not there are notes.
TEST(MidairCheckModels, LooksThatAreMissingAreNotes)
{
    nlohmann::json json = checkedJson(
        modelFile("plain.obj", "mtllib nowhere.mtl\nusemtl gone\n" + kPlate + "f 1 2 3 4\n"), 0);
    // The kit says which file, OSG which material.
    ASSERT_GE(json["reading"].size(), 1u) << json["reading"];
    for (const nlohmann::json& line : json["reading"])
        EXPECT_EQ(line["severity"], "notice") << line;
    EXPECT_NE(json["reading"][0]["text"].dump().find("nowhere.mtl"), std::string::npos);
    modelFile("torn.mtl", "newmtl a\nmap_Kd nowhere.png\n");
    json = checkedJson(modelFile("torn.obj",
                                 "mtllib midair-check-torn.mtl\nusemtl a\n" + kPlate +
                                     "vt 0 0\nf 1/1 2/1 3/1 4/1\n"),
                       0);
    for (const nlohmann::json& line : json["reading"])
        EXPECT_EQ(line["severity"], "notice") << line;
    // Faces against their normals are turned, and felt.
    json =
        checkedJson(modelFile("turned.obj",
                              kPlate + "vn 0 0 -1\nf 1//1 2//1 3//1 4//1\nf 4//1 3//1 2//1 1//1\n"),
                    0);
    EXPECT_NE(json["reading"].dump().find("were reversed"), std::string::npos) << json["reading"];
    // A face that is left out is a warning where the rest is felt.
    json = checkedJson(modelFile("two.obj", kPlate + "f 1 2\nf 1 2 3 4\n"), 0);
    EXPECT_EQ(json["verdict"], "WARNING");
    EXPECT_EQ(json["because"], json["reading"][0]["text"]);
    EXPECT_EQ(json["reading"][0]["severity"], "warning");
    EXPECT_NE(json["reading"][0]["text"].dump().find("the face has 2 corners"), std::string::npos);
    EXPECT_NEAR(json["scenes"][0]["objects"][0]["size_m"][0], 0.04, 1e-3);
}

// With .haptic and without: one reader.
TEST(MidairCheckModels, BrokenModelsEndItByNoSignal)
{
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\nproperty list "
                            "uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    const std::string lwo = std::string("FORM\0\0\0\x64LWO2PNTS\0\0\0\x24", 20) +
                            std::string(36, '\0') + "POLS" +
                            std::string("\0\0\0\x0c"
                                        "FACE\0\3\0\0\0\1\xea\x60",
                                        16);
    for (const auto& [name, text, why] :
         {std::tuple<std::string, std::string, std::string>(
              "beyond.obj", kPlate + "f 1 2 9\n", "line 5: the face refers to vertex 9"),
          {"zero.obj", kPlate + "f 0 1 2\n", "line 5: face corner \"0\": indices count from 1"},
          {"comma.obj", "v 0,5 0 0\nf 1 1 1\n", "line 1: \"0,5\" is not a number"},
          {"beyond.ply", ply + "3 0 1 900000000\n", "face 0 refers to vertex 900000000"},
          {"beyond.lwo", lwo, "was killed by signal "}})
        for (const char* haptic : {"", ".haptic"})
        {
            const Outcome outcome = check(modelFile(name, text) + haptic + " --frames 1");
            EXPECT_EQ(outcome.code, 2) << outcome.output;
            EXPECT_NE(outcome.output.find(why), std::string::npos) << outcome.output;
        }
}

TEST(MidairCheckModels, JsonIsAloneOnItsStreamWhateverAPluginPrints)
{
    const std::string file = modelFile(
        "dangling.dae",
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
        "version=\"1.4.1\"><asset><unit name=\"meter\" meter=\"1\"/><up_axis>Y_UP</up_axis>"
        "</asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array "
        "id=\"pa\" count=\"9\">-0.03 -0.02 0 0.03 -0.02 0 0.03 0.02 0</float_array>"
        "<technique_common><accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" "
        "type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/>"
        "</accessor></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
        "source=\"#p\"/></vertices><triangles count=\"1\"><input semantic=\"VERTEX\" "
        "source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry>"
        "</library_geometries><library_visual_scenes><visual_scene id=\"s\"><node id=\"n\">"
        "<instance_geometry url=\"#g\"/><instance_camera url=\"#nocam\"/></node></visual_scene>"
        "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
    // Without stderr, where the plugin's words then are.
    const Outcome outcome = shell("sh -c 'OSG_MIDAIR_GRANTS= " + kProgram + " --json --frames 1 " +
                                  file + " 2>/dev/null'");
    if (outcome.code == 2) GTEST_SKIP() << "OSG's reader of .dae is not there";
    const nlohmann::json json = nlohmann::json::parse(outcome.output, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << outcome.output;
    EXPECT_EQ(json["scenes"].size(), 1u);
}

// In the kit, without a scene and by Python alike; tests/engine-bridge has the C interface.
TEST(MidairCheckModels, WhatIsOneFocusIsAskedAboutAndNoLouderThanAPointOfTheWhole)
{
    const std::string tiny = modelFile(
        "tiny.obj", "v 0 0 0\nv 0.00004 0 0\nv 0.00004 0.00004 0\nv 0 0.00004 0\nf 1 2 3 4\n");
    const auto highest = [](const nlohmann::json& json)
    { return json["scenes"][0]["objects"][0]["played_Pa"]["highest"].get<double>(); };
    const double whole_Pa = highest(checkedJson(tiny + ".haptic -O size=0.1", 0));
    const nlohmann::json json = checkedJson(tiny, 1);
    const nlohmann::json& object = json["scenes"][0]["objects"][0];
    ASSERT_EQ(object["faults"].size(), 1u) << object;
    EXPECT_NE(object["faults"][0].dump().find("is 4e-05 m wide, under half a wavelength"),
              std::string::npos)
        << object;
    EXPECT_NE(object["faults"][0].dump().find("size=0.08 fits"), std::string::npos) << object;
    EXPECT_EQ(json["scenes"][0]["messages"].dump().find("object.large"), std::string::npos);
    EXPECT_GT(highest(json), 100.0);
    EXPECT_LT(highest(json), whole_Pa);
    const nlohmann::json inPascal = checkedJson(tiny + ".haptic -O 'pressure=90000 Pa'", 1);
    EXPECT_LT(highest(inPascal), whole_Pa);

    const std::string out = testing::TempDir() + "midair-check-tiny";
    const auto solved = [&](const std::string& options)
    {
        const Outcome outcome =
            shell(MIDAIR_BIN "/midair-solve " + tiny + " " + options + " --out " + out);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_EQ(outcome.output.find("object.small") != std::string::npos,
                  options.find("--size") == std::string::npos)
            << outcome.output;
        std::ifstream in(out + "/summary.json");
        return nlohmann::json::parse(in)["report"]["level_Pa"].get<double>();
    };
    const double solvedWhole_Pa = solved("--size 0.1");
    EXPECT_LT(solved(""), solvedWhole_Pa);
    EXPECT_GT(solved(""), 100.0);
    EXPECT_NE(shell(MIDAIR_BIN "/midair-solve " + tiny + " --outline --out " + out).code, 0);
}

/// A plate \a size wide at \a place.
std::string plateOf(double size, double place)
{
    std::string text;
    for (const auto& [x, y] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
        text += fmt::format("v {} {} {}\n", place + x * size, y * size, 0.3 * (x + y) * size);
    return text + "f 1 2 3 4\n";
}

/// Expects that the file is no good with \a options and that the command that is proposed, with \a
/// wanted at its end, mends it.
void expectMended(const std::string& file, const std::string& options, const std::string& wanted)
{
    const Outcome outcome =
        check(file + (options.empty() ? "" : " -O '" + options + "'") + " --json --frames 2");
    const nlohmann::json json = nlohmann::json::parse(outcome.output, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << outcome.output;
    EXPECT_NE(json["verdict"], "OK") << options;
    const std::string remedy = json["remedy"];
    ASSERT_EQ(remedy.find("midair-check "), 0u) << file << options << json["because"];
    ASSERT_GE(remedy.size(), wanted.size());
    EXPECT_EQ(remedy.substr(remedy.size() - wanted.size()), wanted);
    const Outcome mended = shell(MIDAIR_BIN "/" + remedy);
    EXPECT_EQ(mended.code, 0) << remedy << "\n" << mended.output;
    EXPECT_EQ(mended.output.find("OK: "), 0u) << remedy << "\n" << mended.output;
}

TEST(MidairCheckModels, TheCommandThatItNamesMendsIt)
{
    for (const auto& [name, text, wanted] :
         {std::tuple("centimetres.obj", plateOf(6.0, 0.0), ".obj -O \"metresPerUnit=0.01\""),
          {"large.obj", plateOf(1.7, 0.0), ".obj.haptic -O \"size=0.08\""},
          {"wide.obj", plateOf(2.7, 0.0), ".obj.haptic -O \"size=0.08\""},
          {"tiny.obj", plateOf(4e-5, 0.0), ".obj.haptic -O \"size=0.08\""},
          {"far.obj", plateOf(0.05, 20.0), ".obj.haptic -O \"size=0.05\""}})
        expectMended(modelFile(name, text), "", wanted);
}

// Of two parts 4 cm wide, 3 cm apart, each keeps its size and its place.
TEST(MidairCheckModels, AFileInAnotherUnitIsMendedAsAWhole)
{
    const std::string file =
        modelFile("parts.obj",
                  "o left\nv -55 -20 0\nv -15 -20 0\nv -15 20 0\nv -55 20 0\nf 1 2 3 4\n"
                  "o right\nv 15 -20 0\nv 55 -20 0\nv 55 20 0\nv 15 20 0\nf 5 6 7 8\n");
    expectMended(file, "", ".obj -O \"metresPerUnit=0.001\"");
    const nlohmann::json json = checkedJson(file + " -O metresPerUnit=0.001", 0);
    EXPECT_NEAR(json["scenes"][0]["objects"][0]["size_m"][0], 0.11, 2e-3);
}

TEST(MidairCheckModels, OptionsThatPutItOutOfReachAreMended)
{
    const std::string plate = modelFile("options.obj", plateOf(0.06, 0.0));
    expectMended(plate + ".haptic", "size=80", "-O \"size=80 mm\"");
    expectMended(plate + ".haptic", "size=8", "-O \"size=8 cm\"");
    expectMended(
        plate + ".haptic", "size=0.06 position=0 0 30", "-O \"size=0.06 position=0 0 30 mm\"");
    expectMended(plate + ".haptic", "size:0.08", "-O \"size=0.08\"");
    expectMended(plate, "pressure=4000 Pa", ".obj.haptic -O \"pressure=4000 Pa\"");
}

TEST(MidairCheckModels, WhatIsTooWeakIsMended)
{
    const std::string plate = modelFile("weak.obj", plateOf(0.06, 0.0)) + ".haptic";
    expectMended(plate, "pressure=5 Pa", "-O \"pressure=4000 Pa\"");
    // A plate on which 4000 Pa are less than the array's sound would be.
    expectMended(plate, "pressure=4000", "-O \"pressure=4000 Pa\"");
    expectMended(plate, "pressure=4000 Pascal", "-O \"pressure=4000 Pa\"");
}

TEST(MidairCheckModels, EveryUnknownOptionIsToldByItsName)
{
    const std::string plate = modelFile("words.obj", plateOf(0.06, 0.0));
    for (const auto& [file, option, name] :
         {std::tuple(plate + ".haptic", "size:0.08", "size:0.08"),
          {plate + ".haptic", "siez=0.08", "siez"},
          {plate, "siez=0.08", "siez"},
          {plate, "nothing", "nothing"},
          {plate + ".haptic", "nothing", "nothing"}})
    {
        const nlohmann::json json = checkedJson(file + " -O '" + option + "'", 1);
        EXPECT_NE(json["because"].get<std::string>().find(std::string("\"") + name + "\""),
                  std::string::npos)
            << option << json["because"];
    }
    // OSG's reader of OBJ knows it.
    EXPECT_EQ(checkedJson(plate + " -O noRotation", 0)["verdict"], "OK");
    // A cap that can't be read silences, wherever it is written.
    for (const char* ending : {"", ".haptic"})
        for (const char* cap : {"maxPressure:800", "maxPressure 800"})
        {
            const nlohmann::json json = checkedJson(plate + ending + " -O '" + cap + "'", 1);
            EXPECT_EQ(json["scenes"][0]["points"], 0) << cap << json["because"];
        }
}

// The wrong option is the cause, that the model is too large follows from it.
TEST(MidairCheckModels, TheRootCauseIsNamedFirst)
{
    const std::string large = modelFile("cause.obj", plateOf(1.7, 0.0));
    const nlohmann::json json = checkedJson(large + ".haptic -O size:0.08", 1);
    EXPECT_NE(json["because"].get<std::string>().find("size:0.08"), std::string::npos)
        << json["because"];
    const nlohmann::json source = checkedJson(large + " -O hands=nonsense", 1);
    EXPECT_NE(source["because"].get<std::string>().find("nonsense"), std::string::npos)
        << source["because"];
}

TEST(MidairCheckModels, SaysWhyAFileIsNotRead)
{
    const std::string plate = modelFile("why.obj", kPlate + "f 1 2 3 4\n");
    for (const auto& [file, why] :
         {std::pair(plate + ".haptik", std::string("did you mean haptic?")),
          {"/nowhere/model.stl", "there is no such file"},
          {"/nowhere/model.dae", "there is no such file"},
          {modelFile("none.nosuchformat", "a"), "plugin for .nosuchformat is not installed"}})
    {
        const Outcome outcome = check(file);
        EXPECT_EQ(outcome.code, 2) << outcome.output;
        EXPECT_NE(outcome.output.find(why), std::string::npos) << outcome.output;
    }
}

TEST(MidairCheckModels, ASizeWithoutHapticInTheNameIsTold)
{
    const std::string plate = modelFile("sized.obj", kPlate + "f 1 2 3 4\n");
    const nlohmann::json json = checkedJson(plate + " -O size=0.05", 1);
    EXPECT_NE(json["because"].get<std::string>().find("-O size=0.05 "), std::string::npos);
    EXPECT_EQ(json["remedy"], "midair-check " + plate + ".haptic -O \"size=0.05\"");
    EXPECT_EQ(checkedJson(plate + ".haptic -O size=0.05", 0)["remedy"], "");
}

TEST(MidairCheckModels, ASideThatIsATieIsSaid)
{
    const std::string plate = modelFile("plate.obj", kPlate + "f 1 2 3 4\n");
    const nlohmann::json json =
        checkedJson(plate + ".haptic -O 'side=front array=octagon size=0.04'", 1);
    bool isTold = false;
    for (const nlohmann::json& message : json["scenes"][0]["messages"])
        if (message["code"] == "object.side") isTold = message["severity"] == "notice";
    EXPECT_TRUE(isTold) << json["scenes"][0]["messages"];
    const nlohmann::json& faults = json["scenes"][0]["objects"][0]["faults"];
    ASSERT_EQ(faults.size(), 1u) << faults;
    EXPECT_EQ(faults[0].get<std::string>().rfind("side=front: ", 0), 0u) << faults;
}

// The notch of a polygon is no part of it; a fan across it had 8 of 42 points there.
TEST(MidairCheckModels, NoPointIsInTheNotchOfAConcavePolygon)
{
    const std::string u = modelFile("u.obj",
                                    "v -0.03 -0.03 0\nv 0.03 -0.03 0\nv 0.03 0.03 0\nv 0.02 0.03 "
                                    "0\nv 0.02 -0.02 0\nv -0.02 -0.02 0\nv -0.02 0.03 0\nv -0.03 "
                                    "0.03 0\nf 1 2 3 4 5 6 7 8\n");
    const std::string out = testing::TempDir() + "midair-check-u";
    const Outcome outcome = shell(MIDAIR_BIN "/midair-solve " + u + " --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    std::ifstream in(out + "/control_points.csv");
    std::string line;
    std::getline(in, line);
    int points = 0;
    while (std::getline(in, line))
    {
        double x = 0.0;
        double y = 0.0;
        ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf", &x, &y), 2) << line;
        EXPECT_FALSE(std::abs(x) < 0.0199 && y > -0.0199) << line;
        ++points;
    }
    EXPECT_GT(points, 20);
}
