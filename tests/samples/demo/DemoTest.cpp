#include "haptics/probe/Feeling.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/settings/AllSettings.h"
#include "samples/demo/DemoScene.h"

#include <osgMidair/HapticSurface>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace
{

struct Outcome
{
    int status = -1;
    std::string output; ///< both streams
};

Outcome demo(const std::string& arguments)
{
    Outcome run;
    const std::string line = std::string("'") + MIDAIR_BIN + "/midair-demo' " + arguments + " 2>&1";
    FILE* pipe = ::popen(line.c_str(), "r");
    std::array<char, 4096> buffer{};
    while (std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
        run.output.append(buffer.data(), n);
    const int status = ::pclose(pipe);
    run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return run;
}

class Folder
{
public:
    explicit Folder(const std::string& name) :
        path((std::filesystem::temp_directory_path() /
              ("midair_demo_" + name + std::to_string(::getpid())))
                 .string())
    {
        std::filesystem::remove_all(path);
    }
    ~Folder() { std::filesystem::remove_all(path); }
    const std::string path;
};

} // namespace

// osgviewer shows a model as large as it is in its file.
TEST(Demo, SaysWhereItShowsAModelInAnotherSizeThanAViewer)
{
    const Folder out("size");
    std::filesystem::create_directories(out.path);
    const std::string model = out.path + "/square.obj";
    std::ofstream(model) << "v 0 0 0\nv 2.5 0 0\nv 0 1 0\nf 1 2 3\n";
    const std::string run = "--headless --frames 1 --overlays none --out '" + out.path + "' ";
    const std::string scaled = demo(run + model).output;
    EXPECT_NE(scaled.find("size        0.12 m; 2.5 "), std::string::npos) << scaled;
    EXPECT_NE(scaled.find("osgviewer " + model + ".haptic -O size=0.12\n"), std::string::npos)
        << scaled;
    EXPECT_NE(scaled.find("y is up in OBJ files"), std::string::npos) << scaled;
    const std::string whole = demo(run + "--size 2.5 " + model).output;
    EXPECT_EQ(whole.find("size        "), std::string::npos) << whole;
}

TEST(Demo, WritesPicturesReportAndSummary)
{
    const Folder out("star");
    const Outcome run =
        demo("--headless --frames 12 --width 480 --height 320 --sampling vertices --out '" +
             out.path + "'");
    ASSERT_EQ(run.status, 0) << run.output;
    for (const char* line : {"object      star.obj, largest extent 120 mm, 11 control points",
                             "array       octagon, 3984 transducers, 20.0 C",
                             "device      sim:",
                             "frames      12 at",
                             "fields ",
                             "solve ",
                             "accuracy ",
                             "loudness ",
                             "latency ",
                             "pictures "})
        EXPECT_NE(run.output.find(line), std::string::npos) << line << " is missing in\n"
                                                            << run.output;

    std::ifstream file(out.path + "/report.json");
    const nlohmann::json report = nlohmann::json::parse(file);
    EXPECT_EQ(report.at("model"), "star.obj");
    EXPECT_EQ(report.at("transducers"), 3984);
    EXPECT_EQ(report.at("points"), 11);
    EXPECT_EQ(report.at("frames"), 12);
    EXPECT_GT(report.at("solves").get<int>(), 0);
    EXPECT_LE(report.at("solves").get<int>(), report.at("snapshots").get<int>());
    EXPECT_EQ(report.at("meshesSampled"), 1); // it moves, it doesn't change
    EXPECT_GT(report.at("solve_ms").at("median").get<double>(), 0.0);
    EXPECT_LT(report.at("rms").at("median").get<double>(), 0.05);
    EXPECT_GT(report.at("loudness").at("median").get<double>(), 0.3);
    EXPECT_GT(report.at("latency_ms").at("median").get<double>(), 0.0);
    EXPECT_GT(report.at("framesPerSecond").get<double>(), 0.0);
    if (report.contains("picturesProblem")) GTEST_SKIP() << report.at("picturesProblem");
    EXPECT_EQ(report.at("pictures").size(), 6U);
    for (const auto& picture : report.at("pictures"))
    {
        const std::string name = picture.at("file");
        ASSERT_TRUE(std::filesystem::exists(name)) << name;
        EXPECT_GT(std::filesystem::file_size(name), 20000U)
            << name; // an empty picture has a tenth of that
        // The picture and the field in it are of the same moment, and the field is strongest at a
        // control point.
        EXPECT_EQ(picture.at("fieldFrame"), picture.at("frame"));
        EXPECT_LT(picture.at("peakToPoint_mm").get<double>(), 4.3); // half a wavelength
    }
}

TEST(Demo, SaysTheForceAsAllOthersDo)
{
    const Folder out("force");
    const Outcome run = demo("--headless --frames 6 --width 240 --height 160 --sampling vertices "
                             "--overlays none --out '" +
                             out.path + "'");
    ASSERT_EQ(run.status, 0) << run.output;
    std::ifstream file(out.path + "/report.json");
    const nlohmann::json report = nlohmann::json::parse(file);
    const double force_N = report.at("fingertipForce_N");
    EXPECT_NE(run.output.find("\nfeeling     " + midair::haptics::forceText(force_N) + " on"),
              std::string::npos)
        << force_N << " N\n"
        << run.output;
}

// Nobody touches the contacts.
TEST(Demo, HasNoFiguresOfNothing)
{
    const Folder out("nothing");
    const Outcome run = demo("--headless --frames 6 --width 240 --height 160 --sampling vertices "
                             "--render contact --overlays none --out '" +
                             out.path + "'");
    ASSERT_EQ(run.status, 0) << run.output;
    EXPECT_NE(run.output.find("\naccuracy    none"), std::string::npos) << run.output;
    EXPECT_EQ(run.output.find("\nloudness"), std::string::npos) << run.output;
    EXPECT_EQ(run.output.find("\nfeeling"), std::string::npos) << run.output;
    std::ifstream file(out.path + "/report.json");
    const nlohmann::json report = nlohmann::json::parse(file);
    EXPECT_EQ(report.at("points"), 0);
    EXPECT_TRUE(report.at("rms").is_null());
    EXPECT_TRUE(report.at("loudness").is_null());
}

TEST(Demo, SaysWhatIsWrong)
{
    const Outcome missing = demo("--headless nowhere.obj");
    EXPECT_EQ(missing.status, 1);
    EXPECT_NE(missing.output.find("midair-demo: can't read the model nowhere.obj: no such file\n"),
              std::string::npos)
        << missing.output;
    const Outcome option = demo("--temperature 100");
    EXPECT_NE(option.status, 0);
    EXPECT_NE(option.output.find("--temperature: is \"100\", should be a number, -40 .. 60"),
              std::string::npos)
        << option.output;
    const Outcome sampling = demo("--sampling corners");
    EXPECT_NE(sampling.status, 0);
    EXPECT_NE(sampling.output.find(
                  "--sampling: is \"corners\", should be one of surface, edges, vertices"),
              std::string::npos)
        << sampling.output;
}

TEST(Demo, HelpNamesEveryOption)
{
    const Outcome help = demo("--help");
    EXPECT_EQ(help.status, 0);
    for (const char* option : {"--size",
                               "--array",
                               "--device",
                               "--solver",
                               "--temperature",
                               "--sampling",
                               "--spacing",
                               "--pressure",
                               "--max-points",
                               "--still",
                               "--frames",
                               "--out",
                               "--headless",
                               "--benchmark"})
        EXPECT_NE(help.output.find(option), std::string::npos) << option;
}

namespace
{

/// "maxPressure" is --max-pressure.
std::string optionOf(const std::string& setting)
{
    std::string option = "--";
    for (const char c : setting)
        option += c >= 'A' && c <= 'Z' ? std::string("-") + static_cast<char>(c - 'A' + 'a')
                                       : std::string(1, c);
    return option;
}

/// The words of \a text with one blank between them: help breaks lines.
std::string flowing(const std::string& text)
{
    std::istringstream words(text);
    std::string all;
    for (std::string word; words >> word;)
        all += (all.empty() ? "" : " ") + word;
    return all;
}

} // namespace

TEST(Demo, HelpTellsEverySettingAndOverlay)
{
    const std::string help = flowing(demo("--help").output);
    for (const auto& row : osgMidair::sceneSettings().rows())
    {
        EXPECT_NE(help.find(optionOf(row.name)), std::string::npos) << row.name;
        EXPECT_NE(help.find(flowing(row.summary())), std::string::npos) << row.summary();
    }
    for (const auto& row : osgMidair::surfaceProperties().rows())
    {
        if (row.name == "unit") continue;
        EXPECT_NE(help.find(optionOf(row.name)), std::string::npos) << row.name;
    }
    for (const auto& [place, kind] : osgMidair::overlayKinds())
        EXPECT_NE(help.find(kind.word + ","), std::string::npos) << kind.word;
}

TEST(Demo, OptionsReachTheSceneAndTheObject)
{
    const std::vector<const char*> arguments = {"midair-demo",
                                                "--device=null:",
                                                "--no-phase-only",
                                                "--monitor-interval",
                                                "2",
                                                "--max-points=17",
                                                "--side",
                                                "front",
                                                "--modulation=120",
                                                "--touch-events",
                                                "--pressure=300"};
    midair::samples::DemoOptions options;
    int status = 0;
    ASSERT_TRUE(midair::samples::parseDemoOptions(
        static_cast<int>(arguments.size()), const_cast<char**>(arguments.data()), options, status));
    midair::samples::DemoScene scene(options);
    osgMidair::HapticSettings wanted;
    wanted.device = "null:";
    wanted.phaseOnly = false;
    wanted.monitorInterval = 2.0;
    wanted.maxPoints = 17;
    EXPECT_TRUE(scene.haptics().getSettings() == wanted);
    const osg::Group* moved = scene.haptics().getChild(0)->asGroup();
    const auto* surface = dynamic_cast<const osgMidair::HapticSurface*>(moved->getChild(0));
    ASSERT_NE(surface, nullptr);
    osgMidair::HapticProperty property;
    property.side = osgMidair::HapticProperty::FRONT;
    property.modulationFrequency = 120.0;
    property.touchEvents = true;
    property.pressure = 300.0;
    property.pressureUnit = osgMidair::HapticProperty::PASCAL;
    EXPECT_TRUE(surface->getProperty() == property);
}

TEST(Demo, OverlaysAreChosenByName)
{
    const Outcome wrong = demo("--overlays points,fog");
    EXPECT_NE(wrong.status, 0);
    EXPECT_NE(wrong.output.find("fog"), std::string::npos) << wrong.output;
    const Outcome run = demo("--benchmark --frames 3 --overlays volume --sampling vertices");
    ASSERT_EQ(run.status, 0) << run.output;
    EXPECT_NE(run.output.find("slice       0.0/s"), std::string::npos) << run.output;
    EXPECT_NE(run.output.find("ms a frame in all threads"), std::string::npos) << run.output;
}

// The units are in the program, the driver that opens them in libmidair: both have one list of
// devices.
TEST(Demo, PlaysOnUnitsThatAreEmulatedInIt)
{
    const Folder out("units");
    const Outcome run =
        demo("--headless --frames 12 --width 240 --height 160 --sampling vertices --array autd3 "
             "--device 'sim:?board=autd3&units=1' --out '" +
             out.path + "'");
    ASSERT_EQ(run.status, 0) << run.output;
    EXPECT_NE(run.output.find("device      sim: autd3: 1 units"), std::string::npos) << run.output;
    EXPECT_NE(run.output.find(", 0 torn"), std::string::npos) << run.output;
}

TEST(Demo, WritesItsReportsWhenItIsInterrupted)
{
    for (const std::string signal : {"INT", "TERM"})
    {
        const Folder out("signal" + signal);
        std::filesystem::create_directories(out.path);
        // Frames enough for hours; the kit's report is there a second after the first of them.
        const std::string kit = out.path + "/kit.json";
        const std::string line =
            "bash -c 'set -m; OSG_MIDAIR_REPORT=" + kit +
            " \"" MIDAIR_BIN "/midair-demo\" --headless --frames 1000000 --size 0.05 --out " +
            out.path + " > /dev/null 2>&1 & for i in $(seq 600); do [ -s " + kit +
            " ] && break; sleep 0.1; done; kill -s " + signal + " $!; wait $!'";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << signal << " " << status;
        for (const std::string& file : {out.path + "/report.json", kit})
        {
            std::ifstream in(file);
            EXPECT_FALSE(nlohmann::json::parse(in, nullptr, false).is_discarded()) << file;
        }
    }
}
