#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"
#include "tests/plugin/loader/StockPrograms.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>
#include <osgMidair/HapticOverlays>

#include <osg/ComputeBoundsVisitor>
#include <osg/PagedLOD>
#include <osgDB/ReadFile>
#include <osgDB/WriteFile>

#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";

HapticScene* readHaptic(osg::ref_ptr<osg::Node>& keep, const std::string& options)
{
    findPlugins();
    const osg::ref_ptr<osgDB::Options> given = new osgDB::Options(options);
    keep = osgDB::readRefNodeFile(kStar + ".haptic", given);
    return dynamic_cast<HapticScene*>(keep.get());
}

} // namespace

// osgconv ends with 0 whatever it could write.
TEST(Loader, OsgconvSaysThatAKitSceneAsOsgIsNotWritten)
{
    if (!installed("osgconv")) GTEST_SKIP() << "osgconv is not installed";
    const auto file = std::filesystem::path(testing::TempDir()) / "midair-loader-kit.osg";
    std::filesystem::remove(file);
    bool ok = false;
    const std::string output =
        run(stock("osgconv") + " " MIDAIR_ROOT "/samples/scenes/star.osgt " + file.string(), ok);
    EXPECT_NE(output.find("osgMidair: " + file.string() + " is not written: .osg can't hold "),
              std::string::npos)
        << output;
    EXPECT_EQ(output.find("Data written"), std::string::npos) << output;
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Loader, AnyModelBecomesAHapticScene)
{
    osg::ref_ptr<osg::Node> keep;
    HapticScene* scene = readHaptic(
        keep, "noRotation size=0.08 pressure=500 Pa, sampling=edges device=null: array=board");
    ASSERT_NE(scene, nullptr);
    EXPECT_EQ(scene->getDevice(), "null:");
    EXPECT_EQ(scene->getArray(), "board");
    auto* surface = dynamic_cast<HapticSurface*>(scene->getChild(0));
    ASSERT_NE(surface, nullptr);
    EXPECT_EQ(surface->getName(), "star.obj");
    EXPECT_EQ(surface->getPressure(), 500.0);
    EXPECT_EQ(surface->getPressureUnit(), HapticProperty::PASCAL);
    EXPECT_EQ(surface->getSampling(), HapticProperty::EDGES);
    osg::ComputeBoundsVisitor bounds;
    scene->accept(bounds);
    const osg::BoundingBox& box = bounds.getBoundingBox();
    EXPECT_NEAR(box.xMax() - box.xMin(), 0.08, 1e-6); // float vertices
    EXPECT_NEAR(box.center().length(), 0.0, 1e-6);
}

TEST(Loader, WithoutASizeTheModelStaysAsItIs)
{
    osg::ref_ptr<osg::Node> keep;
    HapticScene* scene = readHaptic(keep, "");
    ASSERT_NE(scene, nullptr);
    osg::ComputeBoundsVisitor bounds;
    scene->accept(bounds);
    const osg::BoundingBox& box = bounds.getBoundingBox();
    EXPECT_NEAR(box.xMax() - box.xMin(), 0.12, 1e-6); // float vertices
    EXPECT_TRUE(scene->getSettings() == HapticSettings());
}

TEST(Loader, BadOptionsAreNamed)
{
    Notices handler;
    osg::ref_ptr<osg::Node> keep;
    readHaptic(keep, "size=-1 sampling=holes smell=4");
    for (const char* said : {"size is \"-1\", should be over 0 (metres)",
                             "sampling is \"holes\", should be one of surface, edges, vertices",
                             "unknown option \"smell\""})
        EXPECT_NE(handler.text().find(said), std::string::npos) << handler.text();
}

TEST(Loader, OverlaysAreAllOrThoseThatAreNamed)
{
    const auto shownBy = [](const std::string& options)
    {
        osg::ref_ptr<osg::Node> keep;
        const HapticScene* scene = readHaptic(keep, options);
        std::string words;
        const HapticOverlays* overlays = nullptr;
        for (unsigned int i = 0; scene && i < scene->getNumChildren(); ++i)
            if (const auto* found = dynamic_cast<const HapticOverlays*>(scene->getChild(i)))
                overlays = found;
        if (!overlays) return std::string("none");
        for (const OverlayDescription& one : HapticOverlays::describe())
            if (overlays->isShown(one.word)) words += one.word + " ";
        return words;
    };
    EXPECT_EQ(shownBy("overlays=false"), "none");
    EXPECT_NE(shownBy("overlays=true").find("points slice array "), std::string::npos);
    EXPECT_EQ(shownBy("overlays=contacts"), "contacts ");
    EXPECT_EQ(shownBy("overlays=\"contacts slice\""), "slice contacts ");
    EXPECT_EQ(shownBy("overlays=ShowContacts"), "none");
    Notices handler;
    EXPECT_EQ(shownBy("overlays=contact"), "none");
    EXPECT_NE(handler.text().find("overlays is \"contact\", should be true, false or names of "
                                  "overlays: there is no overlay \"contact\" (did you mean "
                                  "contacts?)"),
              std::string::npos)
        << handler.text();
}

TEST(Loader, ADeviceSaysWhatIsOnlyForModels)
{
    findPlugins();
    const TemporaryFolder folder;
    const std::string file =
        folder.write("desk.haptic", "array=board; size=0.1; rotation=0 0 90\n");
    Notices handler;
    osg::ref_ptr<HapticDevice> device = osgDB::readRefFile<HapticDevice>(file);
    ASSERT_NE(device, nullptr);
    EXPECT_EQ(device->getSettings().array, "board");
    for (const char* said : {": size is for MODEL.haptic ", ": rotation is for MODEL.haptic "})
        EXPECT_NE(handler.text().find(file + ":1" + said), std::string::npos) << handler.text();
}

// Nobody knows which of two caps was meant; the looser one must not win by standing last.
TEST(Loader, WhatIsGivenTwiceIsToldAndSilencesWhereItIsACap)
{
    Notices handler;
    osg::ref_ptr<osg::Node> keep;
    HapticScene* scene = readHaptic(keep, "maxPressure=800 maxPressure=9000 size=0.1 size=0.2");
    ASSERT_NE(scene, nullptr);
    EXPECT_TRUE(scene->getSettings().isSilenced);
    EXPECT_EQ(scene->getSettings().maxPressure, 800.0);
    for (const char* said :
         {"maxPressure is given twice; nothing is played", "size is given twice; the first counts"})
        EXPECT_NE(handler.text().find(said), std::string::npos) << handler.text();
    HapticProperty property;
    std::vector<std::string> errors;
    property.parse("pressure=500 Pa; pressure=5000 Pa", errors);
    EXPECT_EQ(errors, std::vector<std::string>{"pressure is given twice; nothing is played"});
    EXPECT_EQ(property.whySilenced, errors);
    EXPECT_EQ(property.pressure, 500.0);
}

// What is said to silence does so, also where the scene has marks of its own.
TEST(Loader, ADeviceWhosePressureIsNotUnderstoodPlaysNoScene)
{
    findPlugins();
    const TemporaryFolder folder;
    const auto deviceOf = [&](const std::string& text)
    {
        osg::ref_ptr<HapticDevice> device =
            osgDB::readRefFile<HapticDevice>(folder.write("desk.haptic", text));
        return device;
    };
    const osg::ref_ptr<HapticDevice> unclear = deviceOf("array = board\npressure = 0,5\n");
    ASSERT_NE(unclear, nullptr);
    EXPECT_TRUE(unclear->getSettings().isSilenced);
    const osg::ref_ptr<HapticDevice> clear = deviceOf("array = board\npressure = 500 Pa\n");
    ASSERT_NE(clear, nullptr);
    EXPECT_FALSE(clear->getSettings().isSilenced);
    const osg::ref_ptr<HapticSurface> marked = new HapticSurface(BoxScene::box());
    Notices handler;
    HeadlessViewer viewer(marked);
    viewer.viewer.addDevice(clear);
    viewer.frames(3);
    EXPECT_NE(handler.text().find("given for an untagged scene"), std::string::npos)
        << handler.text();
}

TEST(Loader, AMissingModelIsNoScene)
{
    findPlugins();
    EXPECT_EQ(osgDB::readRefNodeFile("/nowhere/bunny.obj.haptic"), nullptr);
}

TEST(Loader, ASettingsFileIsAViewersDevice)
{
    findPlugins();
    const TemporaryFolder folder;
    const std::string file =
        folder.write("desk.haptic", "# the array on the desk\narray = board\nsampling=vertices\n");
    osg::ref_ptr<HapticDevice> device = osgDB::readRefFile<HapticDevice>(file);
    ASSERT_NE(device, nullptr);
    osg::ref_ptr<osg::MatrixTransform> plain =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    plain->addChild(BoxScene::box());
    HeadlessViewer viewer(plain);
    viewer.viewer.addDevice(device);
    ASSERT_TRUE(viewer.framesUntil([&] { return SceneAccess::latestResult(*device) != nullptr; }));
    EXPECT_EQ(SceneAccess::latestResult(*device)->points.size(), 8)
        << "nothing is haptic: all of it is, by the file's property";
    EXPECT_NEAR(SceneAccess::latestResult(*device)->points.positions.row(2).mean(), 0.15, 1e-6);
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box(0.03f).get());
    plain->addChild(surface);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return SceneAccess::latestResult(*device)->points.size() > 8; }))
        << "now something is, and only that";
}

// As OSG looks for what a file names: wherever the program was started.
TEST(Loader, ASettingsFileNamesWhatLiesBesideIt)
{
    findPlugins();
    const TemporaryFolder folder;
    std::filesystem::copy_file(MIDAIR_ROOT "/haptics/array/arrays/ultraino64.json",
                               folder.path / "desk.json");
    const std::string recording = folder.write("hands.csv", "");
    const auto settingsIn = [&](const std::string& text)
    {
        const osg::ref_ptr<osg::Object> object =
            osgDB::readRefObjectFile(folder.write("desk.haptic", text));
        const auto* device = dynamic_cast<HapticDevice*>(object.get());
        return device ? device->getSettings() : HapticSettings();
    };
    const HapticSettings desk = settingsIn("array = desk.json\nhands = recorded:hands.csv?loop\n");
    EXPECT_EQ(desk.array, (folder.path / "desk.json").string());
    EXPECT_EQ(desk.hands, "recorded:" + recording + "?loop");
    // What isn't there stays as it is written: a shipped array, or a file of the working folder.
    const HapticSettings other = settingsIn("array = sonicsurface\nhands = recorded:none.csv\n");
    EXPECT_EQ(other.array, "sonicsurface");
    EXPECT_EQ(other.hands, "recorded:none.csv");
    EXPECT_EQ(settingsIn("array = /etc/hosts\n").array, "/etc/hosts");
}

TEST(Loader, ASceneFileNamesTheArrayBesideIt)
{
    findPlugins();
    const TemporaryFolder folder;
    std::filesystem::copy_file(MIDAIR_ROOT "/haptics/array/arrays/ultraino64.json",
                               folder.path / "desk.json");
    const std::string file = (folder.path / "scene.osgt").string();
    {
        BoxScene box;
        box.scene->setArray("desk.json");
        ASSERT_TRUE(osgDB::writeNodeFile(*box.scene, file));
    }
    const osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(file);
    auto* scene = dynamic_cast<HapticScene*>(node.get());
    ASSERT_TRUE(scene);
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return scene->getField() != nullptr; }));
    EXPECT_EQ(scene->getField()->getArray()->transducers.size(), 64u);
}

TEST(Loader, AGrantNamesTheArrayBesideTheGrants)
{
    findPlugins();
    const TemporaryFolder folder;
    std::filesystem::copy_file(MIDAIR_ROOT "/haptics/array/arrays/ultraino64.json",
                               folder.path / "desk.json");
    ::setenv("OSG_MIDAIR_GRANTS", folder.write("grants", "mine = desk.json\n").c_str(), 1);
    BoxScene box;
    box.scene->setArray("mine");
    HeadlessViewer viewer(box.scene);
    const bool played = viewer.framesUntil([&] { return box.scene->getField() != nullptr; });
    ::unsetenv("OSG_MIDAIR_GRANTS");
    ASSERT_TRUE(played);
    EXPECT_EQ(box.scene->getField()->getArray()->transducers.size(), 64u);
}

TEST(HapticCallback, PlaysUnderAnyRoot)
{
    HapticSettings settings;
    settings.array = "board";
    osg::ref_ptr<HapticCallback> callback = new HapticCallback(settings);
    BoxScene box;
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(box.transform);
    root->addEventCallback(callback);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return SceneAccess::latestResult(*callback) != nullptr; }));
    EXPECT_GT(SceneAccess::latestResult(*callback)->points.size(), 8);
    EXPECT_EQ(callback->getStatistics().objects, 1);
}

TEST(StockPrograms, OsgconvKeepsTheKitsNodes)
{
    if (!installed("osgconv")) GTEST_SKIP() << "osgconv is not installed";
    const TemporaryFolder folder;
    const std::string out = (folder.path / "star.osgt").string();
    bool ok = false;
    const std::string said =
        run(stock("osgconv") + " " MIDAIR_ROOT "/samples/scenes/star.osgt " + out, ok);
    EXPECT_TRUE(ok) << said;
    const std::string text = contents(out);
    EXPECT_NE(text.find("osgMidair::HapticScene {"), std::string::npos);
    EXPECT_NE(text.find("osgMidair::HapticSurface {"), std::string::npos);
    EXPECT_NE(text.find("Name \"star\""), std::string::npos);
}

TEST(StockPrograms, OsgconvListsTheLoadersOptions)
{
    if (!installed("osgconv")) GTEST_SKIP() << "osgconv is not installed";
    bool ok = false;
    const std::string said = run(stock("osgconv") + " --format haptic", ok);
    for (const char* option :
         {"size=<metres>", "pressure=", "spacing=", "device=", "array=", "solver="})
        EXPECT_NE(said.find(option), std::string::npos) << option << "\n" << said;
}

TEST(StockPrograms, ATagSurvivesTheOptimizerAndGoesWithoutTheKit)
{
    if (!installed("osgconv")) GTEST_SKIP() << "osgconv is not installed";
    const TemporaryFolder folder;
    const std::string in = folder.write("tagged.osgt", R"(#Ascii Scene
#Version 161
#Generator OpenSceneGraph 3.6.5
osg::Group { UniqueID 1 Children 1 {
  osg::Group { UniqueID 2
    UserDataContainer TRUE { osg::DefaultUserDataContainer { UniqueID 3
      UDC_UserObjects 1 { osg::StringValueObject { UniqueID 4 Name "haptic" Value "pressure=2" } } } }
    Children 1 { osg::ShapeDrawable { UniqueID 5 Shape TRUE { osg::Box { UniqueID 6 } } } }
  }
} }
)");
    const std::string out = (folder.path / "out.osgt").string();
    bool ok = false;
    const std::string said = run("env -u OSG_LIBRARY_PATH osgconv " + in + " " + out, ok);
    ASSERT_TRUE(ok) << said;
    EXPECT_NE(contents(out).find("Value \"pressure=2\""), std::string::npos) << contents(out);
}

TEST(StockPrograms, OsgviewerPlaysASceneFileAndReports)
{
    if (!installed("osgviewer") || !installed("xvfb-run"))
        GTEST_SKIP() << "osgviewer or xvfb-run is not installed";
    const TemporaryFolder folder;
    const std::string report = (folder.path / "report.json").string();
    bool ok = false;
    const std::string said = run(
        "OSG_RUN_FRAME_COUNT=" + frames() + " OSG_MIDAIR_DEVICE=null: OSG_MIDAIR_REPORT=" + report +
            " xvfb-run -a -s '-screen 0 640x480x24' " + stock("osgviewer") +
            " --window 0 0 320 240 " MIDAIR_ROOT "/samples/scenes/star.osgt",
        ok);
    EXPECT_TRUE(ok) << said;
    const std::string text = contents(report);
    EXPECT_NE(text.find("\"device\": \"null:\""), std::string::npos) << text << said;
    EXPECT_NE(text.find("\"frames\": " + frames() + ","), std::string::npos) << text;
    EXPECT_NE(text.find("\"solves\": 1,"), std::string::npos) << text;
    EXPECT_NE(text.find("\"messages\": []"), std::string::npos) << text;
}

TEST(StockPrograms, OsgviewerPagesAnObjectIn)
{
    if (!installed("osgviewer") || !installed("xvfb-run"))
        GTEST_SKIP() << "osgviewer or xvfb-run is not installed";
    findPlugins();
    const TemporaryFolder folder;
    const std::string page = (folder.path / "page.osgt").string();
    const std::string file = (folder.path / "scene.osgt").string();
    const std::string report = (folder.path / "report.json").string();
    const osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box().get());
    surface->setSampling(HapticProperty::VERTICES);
    ASSERT_TRUE(osgDB::writeNodeFile(*surface, page));
    osg::ref_ptr<osg::PagedLOD> paged = new osg::PagedLOD;
    paged->setCenter(osg::Vec3());
    paged->setRadius(0.1f);
    paged->setFileName(0, "page.osgt");
    paged->setRange(0, 0.0f, 1e6f);
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->addChild(paged);
    ASSERT_TRUE(osgDB::writeNodeFile(*scene, file));
    bool ok = false;
    const std::string said = run("OSG_RUN_FRAME_COUNT=" + frames() +
                                     " OSG_MIDAIR_DEVICE=null: OSG_MIDAIR_REPORT=" + report +
                                     " xvfb-run -a -s '-screen 0 640x480x24' " +
                                     stock("osgviewer") + " --window 0 0 160 120 " + file,
                                 ok);
    EXPECT_TRUE(ok) << said;
    const std::string text = contents(report);
    EXPECT_NE(text.find("\"objects\": 1,"), std::string::npos) << text << said;
    EXPECT_NE(text.find("\"points\": 8,"), std::string::npos) << text;
    EXPECT_NE(text.find("\"meshesRead\": 1,"), std::string::npos) << text;
}

TEST(StockPrograms, OsgviewerLeavesAReportWhenASignalEndsIt)
{
    if (!installed("osgviewer") || !installed("xvfb-run"))
        GTEST_SKIP() << "osgviewer or xvfb-run is not installed";
    const TemporaryFolder folder;
    const std::string report = (folder.path / "report.json").string();
    bool ok = false;
    // Killed once the report has a field, after a minute at the latest.
    const std::string said =
        run("OSG_MIDAIR_DEVICE=null: OSG_MIDAIR_REPORT=" + report +
                " xvfb-run -a -s '-screen 0 640x480x24' sh -c '" + stock("osgviewer") +
                " --window 0 0 160 120 " MIDAIR_ROOT "/samples/scenes/star.osgt & viewer=$!; "
                "for i in $(seq 600); do grep -q achieved_Pa " +
                report +
                " 2>/dev/null && break; sleep 0.1; done; kill -KILL $viewer; wait $viewer; true'",
            ok);
    EXPECT_TRUE(ok) << said;
    const std::string text = contents(report);
    EXPECT_NE(text.find("/HapticSurface 'star'\""), std::string::npos) << text << said;
    EXPECT_EQ(text.substr(text.size() - std::min<std::size_t>(text.size(), 2)), "}\n") << text;
}
