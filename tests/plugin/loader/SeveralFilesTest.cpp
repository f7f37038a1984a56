// osgviewer a.obj.haptic b.obj.haptic: one scene with two objects.
#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"
#include "tests/plugin/loader/StockPrograms.h"

#include <osg/ComputeBoundsVisitor>
#include <osgDB/ReadFile>

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace osgMidair;

namespace
{

const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";

/// Files read as osgviewer reads its arguments: each with the same options, below one group.
struct SeveralFiles : testing::Test
{
    osg::ref_ptr<osg::Group> root;
    std::vector<HapticScene*> scenes;

    void read(std::vector<std::string> names,
              const std::string& options = "array=board device=null:")
    {
        findPlugins();
        const osg::ref_ptr<osgDB::Options> given = new osgDB::Options(options);
        for (std::string& name : names)
            name = kStar + name;
        const osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFiles(names, given);
        root = node ? node->asGroup() : nullptr;
        scenes.clear();
        for (unsigned int i = 0; root && i < root->getNumChildren(); ++i)
            scenes.push_back(dynamic_cast<HapticScene*>(root->getChild(i)));
    }

    static std::string told(const HapticScene& scene)
    {
        std::string all;
        for (const HapticMessage& message : scene.getStatistics().told)
            all += message.code + ": " + message.text + "\n";
        return all;
    }

    static std::size_t objects(const HapticScene& scene)
    {
        const auto field = scene.getField();
        return field ? field->getObjects().size() : 0;
    }
};

} // namespace

TEST_F(SeveralFiles, AreOneSceneWithAnObjectEach)
{
    read({".(size=4cm, position=-3cm 0 15cm, pressure=2).haptic",
          ".(size=2cm, position=3cm 0 15cm; sampling=edges).haptic"});
    ASSERT_EQ(scenes.size(), 2u);
    ASSERT_TRUE(scenes[0] && scenes[1]);
    EXPECT_EQ(dynamic_cast<HapticSurface*>(scenes[0]->getChild(0))->getPressure(), 2.0);
    EXPECT_EQ(dynamic_cast<HapticSurface*>(scenes[1]->getChild(0))->getSampling(),
              HapticProperty::EDGES);
    osg::ComputeBoundsVisitor bounds;
    scenes[1]->accept(bounds);
    EXPECT_NEAR(bounds.getBoundingBox().xMax(), 0.04, 1e-6); // float vertices
    EXPECT_NEAR(bounds.getBoundingBox().xMin(), 0.02, 1e-6);

    HeadlessViewer viewer(root);
    ASSERT_TRUE(viewer.framesUntil([&] { return objects(*scenes[0]) == 2; }));
    EXPECT_EQ(scenes[0]->getStatistics().objects, 2);
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return scenes[0]->getStatistics().state == ArrayState::PLAYING; }));
    EXPECT_TRUE(told(*scenes[0]).empty()) << told(*scenes[0]);
    EXPECT_EQ(scenes[1]->getStatistics().state, ArrayState::CLOSED);
    EXPECT_EQ(scenes[1]->getField(), nullptr);
    const std::string said = told(*scenes[1]);
    EXPECT_EQ(said.find("scene.inside: the HapticScene \""), 0u) << said;
    EXPECT_NE(said.find("is joined with the HapticScene \""), std::string::npos) << said;
}

TEST_F(SeveralFiles, AreFeltWhereTheyAreSeen)
{
    read({".(size=4cm, position=-3cm 0 15cm).haptic", ".(size=4cm, position=3cm 0 15cm).haptic"});
    ASSERT_EQ(scenes.size(), 2u);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(viewer.framesUntil([&] { return objects(*scenes[0]) == 2; }));
    const auto isOnlyLeft = [&]
    {
        const auto field = scenes[0]->getField();
        const auto& points = field->getPoints();
        return !points.empty() &&
               std::all_of(points.begin(),
                           points.end(),
                           [](const auto& point) { return point.position.x() < 0.0; });
    };
    EXPECT_FALSE(isOnlyLeft());
    scenes[1]->setNodeMask(0);
    EXPECT_TRUE(viewer.framesUntil(isOnlyLeft)) << "hidden";
    scenes[1]->setNodeMask(~0u);
    EXPECT_TRUE(viewer.framesUntil([&] { return !isOnlyLeft(); })) << "shown";
    scenes[1]->setEnabled(false);
    EXPECT_TRUE(viewer.framesUntil(isOnlyLeft)) << "disabled";
    scenes[1]->setEnabled(true);
    EXPECT_TRUE(viewer.framesUntil([&] { return !isOnlyLeft(); })) << "enabled";
    // The first goes: the other plays for itself.
    const osg::ref_ptr<HapticScene> other = scenes[1];
    root->removeChild(0u, 1u);
    EXPECT_TRUE(viewer.framesUntil(
        [&]
        { return objects(*other) == 1 && other->getStatistics().state == ArrayState::PLAYING; }));
}

TEST_F(SeveralFiles, KeepTheStricterCap)
{
    read({".(size=4cm, position=-3cm 0 15cm).haptic",
          ".(size=4cm, position=3cm 0 15cm, maxAmplitude=0.3).haptic"});
    ASSERT_EQ(scenes.size(), 2u);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(viewer.framesUntil([&] { return objects(*scenes[0]) == 2; }));
    for (const std::complex<float>& q : scenes[0]->getField()->getActivations())
        EXPECT_LE(std::abs(q), 0.31f);
}

TEST_F(SeveralFiles, WithDifferentArraysOrDevicesStayApart)
{
    read({".(size=4cm, position=-3cm 0 15cm).haptic",
          ".(size=4cm, position=3cm 0 15cm, array=octagon).haptic"});
    ASSERT_EQ(scenes.size(), 2u);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return objects(*scenes[0]) == 1 && objects(*scenes[1]) == 1; }));
    EXPECT_EQ(scenes[0]->getField()->getArray()->transducers.size(), 249u);
    EXPECT_GT(scenes[1]->getField()->getArray()->transducers.size(), 249u);
}

TEST_F(SeveralFiles, ATypingErrorInANameSilencesAll)
{
    read({".(size=4cm, position=-3cm 0 15cm).haptic",
          ".(size=4cm, position=3cm 0 15cm, maxPresure=500).haptic"});
    ASSERT_EQ(scenes.size(), 2u);
    HeadlessViewer viewer(root);
    viewer.frames(5);
    const auto isSilent = [&]
    {
        return told(*scenes[0]).find("scene.limit") != std::string::npos &&
               told(*scenes[0]).find("maxPresure") != std::string::npos;
    };
    EXPECT_TRUE(viewer.framesUntil(isSilent)) << told(*scenes[0]);
}

// Made in code: each has its own simulated array, a real one has one owner.
TEST_F(SeveralFiles, ScenesOfAProgramAreApartUnlessJoined)
{
    BoxScene one(osg::Vec3(-0.04f, 0.0f, 0.15f));
    BoxScene two(osg::Vec3(0.04f, 0.0f, 0.15f));
    root = new osg::Group;
    root->addChild(one.scene);
    root->addChild(two.scene);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return objects(*one.scene) == 1 && objects(*two.scene) == 1; }));
    EXPECT_TRUE(told(*two.scene).empty()) << told(*two.scene);
    one.scene->setJoined(true);
    two.scene->setJoined(true);
    EXPECT_TRUE(two.scene->getJoined());
    EXPECT_TRUE(viewer.framesUntil([&] { return objects(*one.scene) == 2; }));
    EXPECT_TRUE(
        viewer.framesUntil([&] { return two.scene->getStatistics().state == ArrayState::CLOSED; }));
}

TEST_F(SeveralFiles, ASecondOwnerOfARealDeviceIsSilent)
{
    const TemporaryFolder folder;
    BoxScene one;
    BoxScene two;
    for (BoxScene* box : {&one, &two})
        box->scene->setDevice("record:" + (folder.path / "fields").string());
    one.transform->setName("pedestal");
    root = new osg::Group;
    root->addChild(one.scene);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return one.scene->getStatistics().state == ArrayState::PLAYING; }));
    root->addChild(two.scene);
    const auto isRefused = [&]
    {
        return told(*two.scene).find("device.open: device \"record:") != std::string::npos &&
               told(*two.scene).find("is driven by the HapticScene with \"pedestal\"") !=
                   std::string::npos;
    };
    EXPECT_TRUE(viewer.framesUntil(isRefused)) << told(*two.scene);
    viewer.frames(50);
    EXPECT_NE(two.scene->getStatistics().state, ArrayState::PLAYING);
    EXPECT_EQ(two.scene->getStatistics().fields.played, 0u);
}

TEST(StockPrograms, OsgviewerPlaysTwoFilesAsOneScene)
{
    if (!installed("osgviewer") || !installed("xvfb-run"))
        GTEST_SKIP() << "osgviewer or xvfb-run is not installed";
    const TemporaryFolder folder;
    const std::string report = (folder.path / "report.json").string();
    bool ok = false;
    const std::string said = run(
        "OSG_RUN_FRAME_COUNT=" + frames() + " OSG_MIDAIR_DEVICE=null: OSG_MIDAIR_REPORT=" + report +
            " xvfb-run -a -s '-screen 0 640x480x24' " + stock("osgviewer") +
            " --window 0 0 160 120 '" + kStar + ".(size=4cm,position=-3cm 0 0).haptic' '" + kStar +
            ".(size=2cm,position=3cm 0 0).haptic'",
        ok);
    EXPECT_TRUE(ok) << said;
    const auto all = nlohmann::json::parse(contents(report), nullptr, false);
    ASSERT_FALSE(all.is_discarded()) << said;
    ASSERT_EQ(all["scenes"].size(), 1u) << all;
    const nlohmann::json& json = all["scenes"][0];
    ASSERT_EQ(json["objects"].size(), 2u) << json;
    EXPECT_EQ(json["state"], "playing");
    EXPECT_TRUE(json["messages"].empty()) << json["messages"];
    for (const auto& object : json["objects"])
    {
        double least = 1.0;
        double most = -1.0;
        for (const auto& row : object["controlPoints"]["rows"])
        {
            least = std::min(least, row[0].get<double>());
            most = std::max(most, row[0].get<double>());
        }
        const bool isLeft = most < 0.0;
        EXPECT_GE(least, isLeft ? -0.0501 : 0.0199) << object;
        EXPECT_LE(most, isLeft ? -0.0099 : 0.0401) << object;
    }
}
