#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticSensation>

#include <osg/ValueObject>
#include <osgDB/ReadFile>
#include <osgDB/Registry>
#include <osgDB/WriteFile>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

/// A sensation below a transform over one board.
struct Sensations
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform;
    osg::ref_ptr<HapticSensation> node;
    HeadlessViewer viewer{scene};

    explicit Sensations(const std::string& sensation) : node(new HapticSensation(sensation))
    {
        scene->setArray("board");
        scene->setFeelThreshold(1e-6);
        node->setName("circle");
        node->setPressure(500.0);
        node->setPressureUnit(HapticProperty::PASCAL);
        transform->addChild(node);
        transform->setMatrix(osg::Matrixd::scale(2.0, 2.0, 2.0) *
                             osg::Matrixd::translate(0.0, 0.0, 0.15));
        scene->addChild(transform);
    }

    std::shared_ptr<const midair::bridge::HologramResult> result() const
    {
        return SceneAccess::latestResult(*scene);
    }
    bool isPlaying() const
    {
        return result() && result()->touched && !result()->touched->sensations.empty() &&
               result()->touched->sensations[0].intensity > 0.0 &&
               result()->state == midair::bridge::ArrayState::PLAYING;
    }
    bool says(const std::string& what) const
    {
        const auto messages = scene->getStatistics().messages;
        return std::any_of(messages.begin(),
                           messages.end(),
                           [&](const std::string& message)
                           { return message.find(what) != std::string::npos; });
    }
};

} // namespace

TEST(HapticSensation, PlaysAtItsPlaceWhateverTheScale)
{
    Sensations scene("circle?radius=10mm");
    ASSERT_TRUE(scene.viewer.framesUntil([&] { return scene.isPlaying(); }));
    const midair::bridge::SensationView view = scene.result()->touched->sensations[0];
    EXPECT_NEAR(view.place.head<2>().norm(), 0.01, 1e-6) << "millimetres stay millimetres";
    EXPECT_NEAR(view.place.z(), 0.15, 1e-6);
    EXPECT_FALSE(view.trail.empty());
    EXPECT_GT(scene.result()->counters.contactFields, 0u);
    ASSERT_EQ(scene.result()->points.size(), 1);
    EXPECT_GT(scene.result()->points.targets[0], 0.0f);
}

TEST(HapticSensation, TheProgramBeginsAndEndsIt)
{
    Sensations scene("circle?radius=10mm");
    scene.node->setTrigger(HapticProperty::PROGRAM);
    EXPECT_TRUE(scene.viewer.framesUntil([&] { return scene.result() != nullptr; }));
    EXPECT_FALSE(scene.isPlaying());
    scene.node->play();
    EXPECT_TRUE(scene.viewer.framesUntil([&] { return scene.isPlaying(); }));
    scene.node->stop();
    EXPECT_TRUE(scene.viewer.framesUntil(
        [&] { return scene.result()->state == midair::bridge::ArrayState::SILENT; }));
    scene.node->play();
    EXPECT_EQ(scene.node->getPlays(), 2);
    EXPECT_TRUE(scene.viewer.framesUntil([&] { return scene.isPlaying(); }));
    scene.scene->setMuted(true);
    EXPECT_TRUE(scene.viewer.framesUntil(
        [&] { return scene.result()->state == midair::bridge::ArrayState::MUTED; }));
}

TEST(HapticSensation, ParametersReachThePattern)
{
    Sensations scene("circle?radius=10mm");
    scene.node->setParameter("radius", 5.0);
    scene.node->setParameter("frequency", 60.0);
    scene.node->setParameter("radius", 6.0);
    scene.node->setParameter("radius", std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(scene.node->getParameters(), "radius=6; frequency=60");
    ASSERT_TRUE(scene.viewer.framesUntil([&] { return scene.isPlaying(); }));
    EXPECT_NEAR(scene.result()->touched->sensations[0].place.head<2>().norm(), 0.006, 1e-6);
}

// Whatever can't be read plays nothing, its surface included, and says why.
TEST(HapticSensation, OneThatCannotBeReadIsSilentAndSaysWhy)
{
    Sensations scene("cirle");
    scene.node->addChild(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.02f)));
    EXPECT_TRUE(scene.viewer.framesUntil([&] { return scene.says("cirle"); }));
    EXPECT_TRUE(scene.says("circle")) << "the nearest one";
    EXPECT_TRUE(scene.says("it is silent"));
    ASSERT_TRUE(scene.viewer.framesUntil([&] { return scene.result() != nullptr; }));
    scene.viewer.frames(20);
    EXPECT_EQ(scene.result()->state, midair::bridge::ArrayState::SILENT);
    EXPECT_EQ(scene.result()->points.size(), 0);
}

TEST(HapticSensation, TagsNameOneOnAnyNode)
{
    BoxScene box;
    const osg::ref_ptr<osg::Group> tagged = new osg::Group;
    tagged->setUserValue("haptic",
                         std::string("sensation=circle?radius=5mm&frequency=50Hz; pressure=500 Pa; "
                                     "parameters=radius=7"));
    tagged->addChild(BoxScene::box(0.02f));
    box.transform->removeChild(box.surface);
    box.transform->addChild(tagged);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&]
        {
            return box.result() && box.result()->touched &&
                   !box.result()->touched->sensations.empty() && box.points() == 1;
        }));
    EXPECT_NEAR(box.result()->touched->sensations[0].place.head<2>().norm(), 0.007, 1e-6);
}

TEST(HapticSensation, IsKeptInFiles)
{
    const osg::ref_ptr<HapticSensation> node = new HapticSensation("click?repeat=yes");
    node->setAttach("hand:palm");
    node->setTrigger(HapticProperty::TOUCH_STAY);
    node->setSensationSpeed(0.5);
    node->setSeed(7);
    node->setParameter("radius", 4.5);
    node->setPlays(3);
    findPlugins();
    for (const char* type : {"Ascii", "Binary", "XML"})
    {
        auto* format = osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
        const osg::ref_ptr<osgDB::Options> options =
            new osgDB::Options(std::string("fileType=") + type);
        std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
        ASSERT_TRUE(format->writeNode(*node, stream, options).success()) << type;
        const osg::ref_ptr<osg::Node> back = format->readNode(stream, options).takeNode();
        const auto* read = dynamic_cast<HapticSensation*>(back.get());
        ASSERT_TRUE(read) << type;
        EXPECT_EQ(read->getProperty(), node->getProperty()) << type;
    }
}

TEST(HapticSensation, CopiesGoOnCounting)
{
    const osg::ref_ptr<HapticSensation> node = new HapticSensation("click");
    node->play();
    node->stop();
    const osg::ref_ptr<HapticSensation> copy =
        dynamic_cast<HapticSensation*>(node->clone(osg::CopyOp::DEEP_COPY_ALL));
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->getNumChildrenRequiringEventTraversal(), 1u);
    copy->play();
    EXPECT_EQ(copy->getPlays(), 2);
}

// From whatever folder the viewer was started.
TEST(HapticSensation, PatternsAreFoundBesideTheScene)
{
    namespace fs = std::filesystem;
    const fs::path folder =
        fs::temp_directory_path() / ("midair_beside_" + std::to_string(getpid()));
    fs::create_directories(folder);
    fs::copy_file(fs::path(MIDAIR_TEST_DATA) / "sensations/loop.adaptics",
                  folder / "drawn.adaptics",
                  fs::copy_options::overwrite_existing);
    const std::string file = (folder / "scene.osgt").string();
    ASSERT_TRUE(osgDB::writeNodeFile(*Sensations("drawn.adaptics").scene, file));
    const osg::ref_ptr<HapticScene> read = dynamic_cast<HapticScene*>(osgDB::readNodeFile(file));
    ASSERT_TRUE(read);
    HeadlessViewer viewer(read);
    const auto plays = [&]
    {
        const auto result = SceneAccess::latestResult(*read);
        return result && result->touched && !result->touched->sensations.empty() &&
               result->touched->sensations[0].intensity > 0.0;
    };
    EXPECT_TRUE(viewer.framesUntil(plays));
    fs::remove_all(folder);
}
