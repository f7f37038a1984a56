#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osg/Switch>
#include <osgViewer/CompositeViewer>

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

using namespace osgMidair;
using midair::haptics::StopReason;

namespace
{

bool saysExactly(const HapticScene& scene, const std::string& message)
{
    const auto messages = scene.getStatistics().messages;
    return std::find(messages.begin(), messages.end(), message) != messages.end();
}

Eigen::Vector3d middle(const BoxScene& box)
{
    return box.result()->points.positions.rowwise().mean();
}

} // namespace

TEST(HapticScene, PlaysByItselfInAViewer)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    // A cube of 40 mm: points all over it, symmetric up to the random ones on its faces.
    EXPECT_LT((middle(box) - Eigen::Vector3d(0.0, 0.0, 0.15)).norm(), 2e-3);
    EXPECT_GT(box.result()->achieved_Pa.maxCoeff(), 0.0f);
    EXPECT_EQ(SceneAccess::engine(*box.scene).array()->size(), 249);
    const HapticStatistics now = box.scene->getStatistics();
    const auto field = box.scene->getField();
    ASSERT_TRUE(field);
    EXPECT_GT(now.fingertipForce_N, 0.0);
    EXPECT_FALSE(now.feeling.empty());
    EXPECT_EQ(now.figures.back(),
              std::make_pair(std::string("fingertipForce_N"), now.fingertipForce_N));
    double most_N = 0.0;
    for (const HapticField::ControlPoint& point : field->getPoints())
        most_N = std::max(most_N, field->getFingertipForce(point.position, point.normal));
    EXPECT_LE(now.fingertipForce_N, 1.001 * most_N);
    EXPECT_GE(now.fingertipForce_N, 0.7 * most_N);
}

// The threshold is one's own: nobody feels less than 1 N.
TEST(HapticScene, TellsOfAFieldThatNobodyFeels)
{
    BoxScene box;
    box.scene->setFeelThreshold(1.0);
    HeadlessViewer viewer(box.scene);
    const auto isTold = [&]
    {
        const auto active = box.scene->getActiveMessages();
        return std::any_of(active.begin(),
                           active.end(),
                           [](const HapticMessage& one) { return one.code == "field.faint"; });
    };
    ASSERT_TRUE(viewer.framesUntil(isTold));
    EXPECT_EQ(box.scene->getStatistics().feeling, "too weak to feel");
    const auto& point = box.scene->getField()->getPoints().front();
    EXPECT_EQ(box.scene->getField()->getFeeling(point.position, point.normal), "too weak to feel");
    box.scene->setFeelThreshold(1e-6);
    ASSERT_TRUE(viewer.framesUntil([&] { return !isTold(); }));
    EXPECT_EQ(box.scene->getStatistics().feeling, "strong");
}

TEST(HapticScene, ASceneInWhichNothingMovesCostsNoSolves)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const HapticStatistics before = box.scene->getStatistics();
    viewer.frames(50);
    const HapticStatistics after = box.scene->getStatistics();
    EXPECT_EQ(after.solves, 1u);
    EXPECT_EQ(after.snapshots, before.snapshots);
    EXPECT_EQ(after.idleFrames, before.idleFrames + 50);
    EXPECT_EQ(after.meshesRead, 1u);
    EXPECT_EQ(after.meshesSampled, 1u);
}

TEST(HapticScene, FollowsWhatMoves)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    box.move(0.03);
    ASSERT_TRUE(viewer.framesUntil([&] { return middle(box).x() > 0.02; }));
    EXPECT_EQ(box.scene->getStatistics().meshesSampled, 1u);
}

TEST(HapticScene, TheMatrixOfALaterSiblingIsNotStale)
{
    // The transform's own update callback moves it in this frame's update traversal, after the
    // scene's node was visited.
    struct Mover : osg::NodeCallback
    {
        double x = 0.0;
        void operator()(osg::Node* node, osg::NodeVisitor* visitor) override
        {
            static_cast<osg::MatrixTransform*>(node)->setMatrix(
                osg::Matrixd::translate(x, 0.0, 0.15));
            traverse(node, visitor);
        }
    };
    BoxScene box;
    osg::ref_ptr<Mover> mover = new Mover;
    box.transform->setUpdateCallback(mover);
    HeadlessViewer viewer(box.scene);
    viewer.frame();
    mover->x = 0.03;
    viewer.frame();
    const unsigned int frame = viewer.viewer.getFrameStamp()->getFrameNumber();
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result() && box.result()->frame >= frame; }));
    EXPECT_EQ(box.result()->frame, frame);
    EXPECT_NEAR(middle(box).x(), 0.03, 2e-3);
}

TEST(HapticScene, ChangedPropertiesAreHandedOverThoughNothingMoves)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    std::uint64_t handedOver = box.scene->getStatistics().snapshots;
    const auto isNews = [&](const char* what)
    {
        viewer.frames(3);
        EXPECT_EQ(box.scene->getStatistics().snapshots, ++handedOver) << what;
    };
    box.surface->setModulationFrequency(200.0);
    isNews("modulation frequency");
    box.surface->setModulationDepth(0.5);
    isNews("modulation depth");
    box.surface->setPressure(2.0);
    isNews("pressure");
}

TEST(HapticScene, SwitchedOffGoesSilent)
{
    BoxScene box;
    osg::ref_ptr<osg::Switch> root = new osg::Switch;
    root->addChild(box.scene);
    HeadlessViewer viewer(root);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    box.surface->setNodeMask(0);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
    EXPECT_EQ(box.result()->played().cwiseAbs().maxCoeff(), 0.0f);
    box.surface->setNodeMask(~0u);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_EQ(box.scene->getStatistics().meshesSampled, 1u) << "a blink is not sampled again";
    root->setAllChildrenOff(); // above the haptic scene
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
}

TEST(HapticScene, DisabledGoesSilent)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    box.surface->setEnabled(false);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
    box.surface->setEnabled(true);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    box.scene->setEnabled(false);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
}

TEST(HapticScene, TakenOutOfTheViewerGoesSilent)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    viewer.viewer.setSceneData(new osg::Group);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
}

TEST(HapticScene, AddedAndRemovedWhileRunning)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const int one = box.points();
    osg::ref_ptr<osg::MatrixTransform> second =
        new osg::MatrixTransform(osg::Matrixd::translate(0.06, 0.0, 0.15));
    second->addChild(box.surface);
    box.scene->addChild(second);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > one; }));
    EXPECT_EQ(box.scene->getStatistics().objects, 2);
    box.scene->removeChild(second);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == one; }));
}

TEST(HapticScene, ScaledIsSampledAgain)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const int one = box.points();
    box.transform->setMatrix(osg::Matrixd::scale(2.0, 2.0, 2.0) *
                             osg::Matrixd::translate(0.0, 0.0, 0.15));
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 2 * one; }));
    EXPECT_NEAR(box.result()->points.positions.row(0).maxCoeff(), 0.04, 1e-6);
}

TEST(HapticScene, ASceneInMillimetresIsTheSame)
{
    BoxScene metres;
    HeadlessViewer first(metres.scene);
    ASSERT_TRUE(first.framesUntil([&] { return metres.points() > 0; }));
    BoxScene box;
    box.scene->setMetresPerUnit(1e-3);
    box.surface->removeChild(0, 1);
    box.surface->addChild(BoxScene::box(40.0f));
    box.transform->setMatrix(osg::Matrixd::translate(0.0, 0.0, 150.0));
    HeadlessViewer second(box.scene);
    ASSERT_TRUE(second.framesUntil([&] { return box.points() > 0; }));
    ASSERT_EQ(box.points(), metres.points());
    EXPECT_LT((box.result()->points.positions - metres.result()->points.positions).norm(), 1e-6);
}

TEST(HapticScene, TheCalibrationTakesTheWorldToTheArray)
{
    BoxScene box(osg::Vec3(1.0f, 2.0f, 3.0f));
    box.scene->setCalibration(osg::Matrixd::translate(-1.0, -2.0, -3.0) *
                              osg::Matrixd::rotate(0.5, osg::Vec3d(0.0, 0.0, 1.0)) *
                              osg::Matrixd::translate(0.0, 0.0, 0.12));
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_LT((middle(box) - Eigen::Vector3d(0.0, 0.0, 0.12)).norm(), 2e-3);
}

TEST(HapticScene, ATransformAboveTheSceneCounts)
{
    BoxScene box;
    osg::ref_ptr<osg::MatrixTransform> above =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.05));
    above->addChild(box.scene);
    HeadlessViewer viewer(above);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_NEAR(middle(box).z(), 0.2, 2e-3);
}

TEST(HapticScene, ACalibrationThatScalesIsRefused)
{
    BoxScene box;
    box.scene->setCalibration(osg::Matrixd::scale(1000.0, 1000.0, 1000.0));
    HeadlessViewer viewer(box.scene);
    viewer.frame();
    EXPECT_TRUE(saysExactly(
        *box.scene,
        "calibration is not rigid (a scene unit is set by metresPerUnit); nothing is played"));
}

TEST(HapticScene, ValuesOutOfRangeAreNamedWithTheNodePath)
{
    BoxScene box;
    box.surface->setPressure(-3.0);
    box.surface->setModulationDepth(7.0);
    box.scene->setTemperature(1000.0);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_TRUE(saysExactly(*box.scene, "temperature is 1000, should be -40 .. 60; 20 is used"));
    EXPECT_TRUE(
        saysExactly(*box.scene,
                    "HapticScene/MatrixTransform/HapticSurface 'box': pressure is -3, should be "
                    "1e-06 .. 100000; nothing is played"));
    EXPECT_TRUE(
        saysExactly(*box.scene,
                    "HapticScene/MatrixTransform/HapticSurface 'box': modulationDepth is 7, "
                    "should be 0 .. 1; 1 is used"));
}

TEST(HapticScene, BadTransformsAndMeshesAreNamedAndPlayNothing)
{
    const std::string path = "HapticScene/MatrixTransform/HapticSurface 'box': ";
    const std::string matrix =
        path + "its matrix is singular, not finite or a perspective; it can't be felt";
    for (const osg::Matrixd& bad :
         {osg::Matrixd::scale(0.0, 0.0, 0.0),
          osg::Matrixd::scale(1.0, 1.0, 0.0),
          osg::Matrixd::translate(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0)})
    {
        BoxScene box;
        box.transform->setMatrix(bad);
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
        EXPECT_TRUE(saysExactly(*box.scene, matrix));
    }
    BoxScene box;
    box.surface->removeChild(0, 1);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
    EXPECT_TRUE(saysExactly(*box.scene, path + "has no drawables below it; it can't be felt"));
}

TEST(HapticScene, AnArrayThatCannotBeReadIsAMessage)
{
    BoxScene box;
    box.scene->setArray("no such array");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().messages.empty(); }));
    ASSERT_NE(box.result(), nullptr);
    EXPECT_EQ(box.result()->report().stop, StopReason::REFUSED);
    EXPECT_EQ(SceneAccess::engine(*box.scene).array(), nullptr);
    EXPECT_EQ(box.scene->getStatistics().messages[0].rfind("array 'no such array': ", 0), 0u)
        << box.scene->getStatistics().messages[0];
    box.scene->setArray("board");
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; })) << "and goes on when mended";
}

TEST(HapticScene, ADeviceThatCannotBeOpenedIsAMessageAndTheFieldIsShown)
{
    BoxScene box;
    box.scene->setDevice("warp-drive:");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_GT(box.result()->achieved_Pa.maxCoeff(), 0.0f);
    EXPECT_EQ(box.result()->deviceStatus.rfind("not open: ", 0), 0u);
}

TEST(HapticScene, TwoViewsOfOneSceneCollectItOnceAFrame)
{
    BoxScene box;
    osgViewer::CompositeViewer viewer;
    for (int i = 0; i < 2; ++i)
    {
        osg::ref_ptr<osgViewer::View> view = new osgViewer::View;
        view->getCamera()->setGraphicsContext(new osgViewer::GraphicsWindowEmbedded(0, 0, 64, 64));
        view->getCamera()->setViewport(0, 0, 64, 64);
        view->setSceneData(box.scene);
        viewer.addView(view);
    }
    for (int i = 0; i < 10; ++i)
    {
        viewer.advance();
        viewer.eventTraversal();
        viewer.updateTraversal();
    }
    EXPECT_EQ(box.scene->getStatistics().frames, 10u);
    EXPECT_EQ(box.scene->getStatistics().objects, 1);
}

TEST(HapticScene, WithoutAViewerUpdateCollects)
{
    BoxScene box;
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    stamp->setFrameNumber(7);
    box.scene->update(stamp);
    ASSERT_TRUE(eventually([&] { return box.result() != nullptr; }));
    EXPECT_EQ(box.result()->frame, 7u);
}

TEST(HapticScene, KeysBringInTheOverlaysAndMuteTheArray)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const unsigned int children = box.scene->getNumChildren();
    viewer.viewer.getEventQueue()->keyPress(osgGA::GUIEventAdapter::KEY_F7);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.scene->getNumChildren() == children + 1; }));
    EXPECT_STREQ(box.scene->getChild(children)->className(), "HapticOverlays");
    const int points = box.points();
    viewer.frames(5);
    EXPECT_EQ(box.points(), points) << "overlays are not felt";
    viewer.viewer.getEventQueue()->keyPress(osgGA::GUIEventAdapter::KEY_F8);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.scene->getMuted(); }));
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::MUTED);
    const osg::ref_ptr<osg::ApplicationUsage> usage = new osg::ApplicationUsage;
    viewer.viewer.getUsage(*usage);
    EXPECT_EQ(usage->getKeyboardMouseBindings().count("F8"), 1u);
}

TEST(HapticScene, FiguresStandInTheViewersStatistics)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    viewer.viewer.getViewerStats()->collectStats("frame_rate", true);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    viewer.frames(2);
    double solve_ms = 0.0;
    const unsigned int frame = viewer.viewer.getFrameStamp()->getFrameNumber();
    ASSERT_TRUE(viewer.viewer.getViewerStats()->getAttribute(frame, "Haptic solve", solve_ms));
    EXPECT_EQ(solve_ms, box.scene->getStatistics().solve_ms);
}

TEST(HapticScene, TagsAreFeltLikeSurfaces)
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setArray("board");
    osg::ref_ptr<osg::MatrixTransform> tagged =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    tagged->setUserValue("haptic", std::string("pressure=2 sampling=vertices; colour=red"));
    tagged->setName("mug");
    tagged->addChild(BoxScene::box());
    scene->addChild(tagged);
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return SceneAccess::latestResult(*scene) != nullptr; }));
    const auto result = SceneAccess::latestResult(*scene);
    EXPECT_EQ(result->points.size(), 8) << "a box's corners";
    EXPECT_EQ(result->points.targets.minCoeff(), 2.0);
    bool said = false;
    for (const std::string& message : scene->getStatistics().messages)
        said =
            said ||
            message.rfind("HapticScene/MatrixTransform 'mug': unknown option \"colour\"; known are "
                          "enabled, pressure, ",
                          0) == 0;
    EXPECT_TRUE(said);
}
