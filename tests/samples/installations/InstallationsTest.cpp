#include "tests/samples/installations/Run.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

namespace
{

/// What no installation may do: sound where it must be silent, say a thing over and over, lose or
/// be refused fields.
void expectQuiet(const nlohmann::json& report)
{
    EXPECT_EQ(report.at("silence").at("playedMuted"), 0);
    EXPECT_EQ(report.at("silence").at("playedAlone"), 0);
    EXPECT_TRUE(report.at("tooOften").empty()) << report.at("tooOften");
    EXPECT_EQ(report.at("fields").at("lost"), 0);
    EXPECT_EQ(report.at("fields").at("refused"), 0);
    EXPECT_EQ(report.at("fields").at("faults"), 0);
    for (const auto& message : report.at("messages"))
        EXPECT_LT(message.at("severity"), 2) << message;
}

} // namespace

TEST(Installations, ToysArePushedAndFelt)
{
    const OwnFolder out("toybox");
    const Visit run = visit("toybox", "--frames 420", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_EQ(run.report.at("array"), "octagon");
    EXPECT_EQ(run.report.at("transducers"), 3984);
    int pushed = 0;
    double way_mm = 0.0;
    double force_mN = 0.0;
    for (const auto& toy : run.report.at("scene").at("toys"))
    {
        if (toy.at("pushes") > 0 && toy.at("touches") > 0) ++pushed;
        way_mm += toy.at("pushedWay_mm").get<double>();
        force_mN = std::max(force_mN, toy.at("largestForce_mN").get<double>());
    }
    EXPECT_GE(pushed, 3) << run.report.at("scene");
    EXPECT_GT(way_mm, 100.0);
    EXPECT_GT(force_mN, 1.0);
    EXPECT_GT(run.report.at("contactFields"), 0);
    EXPECT_GT(run.report.at("fields").at("played"), 0);
    EXPECT_EQ(run.report.at("scene").at("broughtBack"), 0); // none leaves the box
}

TEST(Installations, ToysRepeatWithTheirSeed)
{
    const auto ways = [](const std::string& seed)
    {
        const OwnFolder out("toybox_" + seed);
        const Visit run = visit("toybox", "--frames 150 --device null: --seed " + seed, out);
        std::vector<double> way_mm;
        if (run.report.contains("scene"))
            for (const auto& toy : run.report.at("scene").at("toys"))
                way_mm.push_back(toy.at("pushedWay_mm"));
        return way_mm;
    };
    const std::vector<double> first = ways("1");
    ASSERT_EQ(first.size(), 5U);
    EXPECT_GT(*std::max_element(first.begin(), first.end()), 0.0);
    EXPECT_EQ(first, ways("1"));
    EXPECT_NE(first, ways("2"));
}

TEST(Installations, PlaysARecordedHand)
{
    const OwnFolder out("recorded");
    const Visit run = visit("gallery",
                            "--frames 240 --size 0.12 --hands '" MIDAIR_ROOT
                            "/samples/hands/star.csv' --seconds 60",
                            out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_GT(run.report.at("framesWithHands"), 100); // from when the file is read
    EXPECT_GT(run.report.at("touches"), 0);
}

// The star and the panel are felt; what can't be read and what has nothing to feel are told, by
// name, once, and passed over.
TEST(Installations, TheGalleryShowsAllModelsAndTellsTheBadOnes)
{
    const OwnFolder out("gallery");
    const std::string models = out.path + "/models";
    std::filesystem::create_directories(models);
    for (const char* name : {"star.obj", "star.mtl", "panel.gltf"})
        std::filesystem::copy_file(std::string(MIDAIR_ROOT "/samples/models/") + name,
                                   models + "/" + name);
    std::ofstream(models + "/broken.obj") << "this is no model\n";
    std::ofstream(models + "/sign.osgt")
        << "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
           "osg::Group { UniqueID 1 Children 1 {\n osgText::Text { UniqueID 2\n"
           "  Font \"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf\"\n  CharacterSize 1 1\n"
           "  Text TRUE \"Hi\"\n  AutoRotateToScreen TRUE\n } } }\n";
    const Visit run = visit(
        "gallery", "'" + models + "' --frames 600 --seconds 1.5 --attract 1 --linger 20", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    const nlohmann::json& scene = run.report.at("scene");
    EXPECT_GE(scene.at("rounds"), 2);
    for (const char* name : {"star.obj", "panel.gltf"})
    {
        EXPECT_TRUE(scene.at("shown").contains(name)) << scene;
        EXPECT_TRUE(scene.at("felt").contains(name)) << scene;
    }
    for (const char* name : {"broken.obj", "sign.osgt"})
    {
        EXPECT_TRUE(scene.at("skipped").contains(name)) << scene;
        const std::string& text = run.outcome.output;
        const std::size_t told = text.find(std::string(name) + " ");
        EXPECT_NE(text.find(name), std::string::npos) << text;
        EXPECT_EQ(text.find("midair-gallery: the model " + models + "/" + name, told + 1),
                  std::string::npos)
            << "told twice: " << text;
    }
    EXPECT_NE(run.outcome.output.find("star.mtl is no model"), std::string::npos);
    const Visit none = visit("gallery", "'" + out.path + "'", out);
    EXPECT_EQ(none.outcome.code, 1);
    EXPECT_NE(none.outcome.output.find("there is no model in the folder"), std::string::npos)
        << none.outcome.output;
}

TEST(Installations, PointsOfWaterMoveWithIt)
{
    const OwnFolder out("water");
    const Visit run = visit("water", "--frames 240 --set render=object --rain 0.4", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    const nlohmann::json& scene = run.report.at("scene");
    EXPECT_GT(scene.at("fieldsCompared"), 50);
    EXPECT_GT(scene.at("dips"), 0);
    EXPECT_GT(scene.at("pointsOffRest_mm"), 2.0);
    EXPECT_LT(scene.at("pointsOffSurface_mm"), 0.2);
    EXPECT_GT(run.report.at("largestForce_mN"), 0.0);
}

TEST(Installations, TheDeskPlaysOnTheArrayOfItsDevice)
{
    const OwnFolder out("desk");
    for (const auto& [device, array, transducers] :
         // A busy machine may keep units waiting for longer than 100 ms.
         {std::tuple<const char*, const char*, int>{
              "sim:?board=autd3&units=1&failsafe=5s", "autd3", 249},
          {"sim:?board=sonicsurface", "sonicsurface", 256}})
    {
        const Visit run = visit("desk", std::string("--frames 400 --device '") + device + "'", out);
        ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
        expectQuiet(run.report);
        EXPECT_EQ(run.report.at("array"), array);
        EXPECT_EQ(run.report.at("transducers"), transducers);
        EXPECT_GT(run.report.at("fields").at("played"), 20) << run.outcome.output;
        EXPECT_GT(run.report.at("scene").at("pointsAtMost"), 5);
        EXPECT_GT(run.report.at("scene").at("presses").at("quick"), 0);
        EXPECT_GT(run.report.at("scene").at("presses").at("trembling"), 0);
    }
}

TEST(Installations, AMutedDeskIsSilent)
{
    const OwnFolder out("muted");
    const Visit run = visit("desk", "--frames 200 --muted", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    EXPECT_EQ(run.report.at("silence").at("framesMuted"), 200);
    EXPECT_EQ(run.report.at("silence").at("playedMuted"), 0);
    EXPECT_EQ(run.report.at("framesPlaying"), 0);
    EXPECT_EQ(run.report.at("state"), "muted");
}

TEST(Installations, NobodyThereIsSilence)
{
    const OwnFolder out("alone");
    const Visit run = visit("desk", "--frames 520 --linger 0.5", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_GT(run.report.at("framesPlaying"), 100);
    EXPECT_GT(run.report.at("silence").at("framesAlone"), 60);
}

TEST(Installations, SayWhatIsWrong)
{
    const OwnFolder out("wrong");
    const std::vector<std::pair<std::string, std::string>> kWrong = {
        {"--window 10x10", "--window: is \"10x10\", should be WIDTHxHEIGHT in pixels"},
        {"--set loudness", "--set: is \"loudness\", should be NAME=VALUE"},
        {"--set maxPressure=loud", "maxPressure is \"loud\""},
        {"--frames 0", "--frames"},
    };
    for (const auto& [arguments, text] : kWrong)
    {
        const Visit run = visit("desk", arguments, out);
        EXPECT_NE(run.outcome.code, 0) << arguments;
        EXPECT_NE(run.outcome.output.find(text), std::string::npos) << run.outcome.output;
    }
    EXPECT_EQ(visit("desk", "--help", out).outcome.code, 0);
}
