#include "engine-bridge/hands/HandSource.h"
#include "tests/engine-bridge/hands/WrittenHands.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/MouseHand>
#include <osgMidair/RigidBodyCallback>

#include <algorithm>
#include <fstream>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Writes down what it is told.
class Diary : public TouchCallback
{
public:
    void enter(const Touch& touch) override { add("enter", touch); }
    void stay(const Touch& touch) override { stays.push_back(touch); }
    void leave(const Touch& touch) override { add("leave", touch); }

    std::vector<std::string> lines;
    std::vector<Touch> touches;
    std::vector<Touch> stays;

protected:
    ~Diary() override = default;

private:
    void add(const std::string& what, const Touch& touch)
    {
        lines.push_back(what + " " + (touch.node ? touch.node->getName() : "nothing"));
        touches.push_back(touch);
    }
};

/// The last bone of a right index finger that points down at \a tip, the middle of its end's ball
/// of 7.5 mm.
Hand finger(const osg::Vec3d& tip)
{
    Hand hand = openHand(1, tip, osg::Quat()); // fingers along -z as they are
    for (std::size_t i = 0; i < Hand::kJoints; ++i)
        hand.joints[i].positionValid = i == 9 || i == 10;
    return hand;
}

/// Its skin \a gap over the box's top, z = 0.17.
Hand pointingDown(double gap)
{
    return finger(osg::Vec3d(0.0, 0.0, 0.17 + 0.0075 + gap));
}

struct TouchedBox : BoxScene
{
    osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    osg::ref_ptr<Diary> diary = new Diary;
    HeadlessViewer viewer{scene};

    TouchedBox()
    {
        scene->setHandSource(hands);
        surface->setTouchEvents(true);
        surface->setTouchCallback(diary);
    }

    void frameWith(double gap)
    {
        hands->setHands({pointingDown(gap)});
        viewer.frame();
    }
};

} // namespace

TEST(Hands, EnterAndLeaveAreToldWithHysteresis)
{
    TouchedBox box;
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.frameWith(0.01);
    EXPECT_TRUE(box.diary->lines.empty());
    box.frameWith(-0.002);
    ASSERT_EQ(box.diary->lines, std::vector<std::string>{"enter box"});
    box.frameWith(0.002);
    EXPECT_EQ(box.diary->lines.size(), 1u);
    EXPECT_EQ(box.scene->getStatistics().touching, 1);
    box.frameWith(0.006);
    ASSERT_EQ(box.diary->lines.size(), 2u);
    EXPECT_EQ(box.diary->lines[1], "leave box");
    EXPECT_EQ(box.scene->getStatistics().touching, 0);
}

TEST(Hands, ATouchSaysWhereAndHowStrong)
{
    TouchedBox box;
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.frameWith(-0.002);
    ASSERT_EQ(box.diary->touches.size(), 1u);
    const Touch& touch = box.diary->touches[0];
    EXPECT_EQ(touch.node, box.surface.get());
    EXPECT_EQ(touch.path, "HapticScene/MatrixTransform/HapticSurface 'box'");
    EXPECT_EQ(touch.bone, "index distal to index tip");
    EXPECT_EQ(touch.hand, 1);
    EXPECT_NEAR(touch.distance, -0.002, 1e-6); // the box's vertices are floats
    EXPECT_NEAR(touch.position.z(), 0.17, 1e-3);
    EXPECT_NEAR(touch.area, 81.7e-6, 2e-6); // a ball of 7.5 mm, 2 mm deep; chords of 2 mm
    const double level = box.result()->report().level_Pa;
    EXPECT_NEAR(
        touch.force, level * level / (1.204 * 343.2 * 343.2) * touch.area, 0.01 * touch.force);
    EXPECT_GT(touch.force, 0.0);
}

TEST(Hands, ATouchThatGoesOnIsToldInEachFrame)
{
    TouchedBox box;
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_TRUE(box.scene->getTouches().empty());
    box.frameWith(-0.002);
    EXPECT_TRUE(box.diary->stays.empty());
    ASSERT_EQ(box.scene->getTouches().size(), 1u);
    EXPECT_EQ(box.scene->getTouches()[0].finger, Touch::INDEX);
    EXPECT_NEAR(box.scene->getTouches()[0].depth, 0.002, 1e-6);
    box.frameWith(-0.003);
    box.frameWith(0.001);
    ASSERT_EQ(box.diary->stays.size(), 2u);
    EXPECT_NEAR(box.diary->stays[0].depth, 0.003, 1e-6);
    EXPECT_GT(box.diary->stays[0].force, box.diary->touches[0].force);
    EXPECT_EQ(box.diary->stays[1].depth, 0.0);
    EXPECT_EQ(box.diary->stays[1].force, 0.0);
    EXPECT_NEAR(box.scene->getTouches()[0].distance, 0.001, 1e-6);
    box.frameWith(0.01);
    EXPECT_EQ(box.diary->stays.size(), 2u);
    EXPECT_TRUE(box.scene->getTouches().empty());
    box.frameWith(-0.002);
    box.scene->silence();
    EXPECT_TRUE(box.scene->getTouches().empty());
}

TEST(Hands, TheForceFollowsThePressureThatIsPlayed)
{
    TouchedBox box;
    box.surface->setPressureUnit(HapticProperty::PASCAL);
    box.surface->setPressure(60.0);
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.frameWith(-0.002);
    box.frameWith(-0.002);
    const double before_N = box.scene->getTouches().at(0).force;
    box.surface->setPressure(30.0);
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.result()->points.targets[0] < 40.0; }));
    box.frameWith(-0.002);
    // One board reaches the pressures to some per cent.
    EXPECT_NEAR(box.scene->getTouches().at(0).force, 0.25 * before_N, 0.04 * before_N);
    box.scene->setMaxAmplitude(0.0); // nothing is played any more
    ASSERT_TRUE(box.viewer.framesUntil(
        [&] {
            return box.result()->achieved_Pa.size() == 0 ||
                   box.result()->achieved_Pa.maxCoeff() == 0.0f;
        }));
    box.frameWith(-0.002);
    EXPECT_EQ(box.scene->getTouches().at(0).force, 0.0);
}

TEST(Hands, AnImpossibleJointTouchesNothingAndIsToldOnce)
{
    TouchedBox box;
    Hand huge = pointingDown(0.05);
    for (HandJoint& joint : huge.joints)
        joint.radius = 1e30;
    Hand far = pointingDown(0.05);
    for (HandJoint& joint : far.joints)
        joint.position.x() = 2000.0;
    for (int i = 0; i < 5; ++i)
    {
        box.hands->setHands({huge, far});
        box.viewer.frame();
    }
    EXPECT_TRUE(box.diary->touches.empty());
    const auto told = box.scene->getStatistics().told;
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told[0].code, "hands.source");
    EXPECT_EQ(
        told[0].text,
        "the index distal of hand 1 is left out: its radius is 1e+30 m, should be up to 0.1 m");
    EXPECT_EQ(told[0].count, 1u);
    box.frameWith(-0.001);
    EXPECT_EQ(box.diary->touches.size(), 1u) << "a hand is felt again";
}

TEST(Hands, PositionsAreInSceneUnits)
{
    TouchedBox box;
    box.scene->setMetresPerUnit(0.001);
    box.scene->setCalibration(
        osg::Matrixd::translate(0, 0, 0.15)); // the box round the world's origin
    box.transform->setMatrix(osg::Matrixd::scale(1000, 1000, 1000));
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.hands->setHands({finger(osg::Vec3d(0.01, 0.0, 0.02 + 0.0055))});
    box.viewer.frame();
    ASSERT_EQ(box.diary->touches.size(), 1u);
    EXPECT_LT((box.diary->touches[0].position - osg::Vec3d(10, 0, 20)).length(), 3.0); // mm
}

TEST(Hands, TouchEventsAreOffUnlessAskedFor)
{
    TouchedBox box;
    box.surface->setTouchEvents(false);
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.frameWith(-0.002);
    EXPECT_TRUE(box.diary->lines.empty());
}

TEST(Hands, ATagIsTouchedThroughTheScenesCallback)
{
    TouchedBox box;
    const osg::ref_ptr<osg::Group> tagged = new osg::Group;
    tagged->setName("tagged");
    tagged->setUserValue("haptic", std::string("touchEvents=true"));
    tagged->addChild(BoxScene::box());
    box.transform->replaceChild(box.surface, tagged);
    box.scene->setTouchCallback(box.diary);
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.frameWith(-0.002);
    EXPECT_EQ(box.diary->lines, std::vector<std::string>{"enter tagged"});
}

TEST(Hands, WhatIsSwitchedOffIsLeft)
{
    TouchedBox box;
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    box.frameWith(-0.002);
    box.transform->setNodeMask(0);
    box.viewer.frame();
    ASSERT_EQ(box.diary->lines.size(), 2u);
    EXPECT_EQ(box.diary->lines[1], "leave box");
    box.transform->setNodeMask(~0u);
    box.viewer.frame();
    ASSERT_EQ(box.diary->lines.size(), 3u);
    box.viewer.viewer.setSceneData(new osg::Group);
    box.viewer.frame();
    ASSERT_EQ(box.diary->lines.size(), 4u);
    EXPECT_EQ(box.diary->lines[3], "leave box");
}

TEST(Hands, OnlyWhatIsWithinReachIsSolved)
{
    TouchedBox box;
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    const int all = box.points();
    box.scene->setReach(0.01);
    // Without a hand nothing is.
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() == 0; }));
    EXPECT_EQ(box.result()->played().cwiseAbs().maxCoeff(), 0.0f);
    box.hands->setHands({pointingDown(0.001)});
    ASSERT_TRUE(box.viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_LT(box.points(), all / 2);
    EXPECT_GT(box.result()->skipped.cols(), all / 2);
    EXPECT_GT(box.scene->getStatistics().outOfReach, 0u);
    const auto solves = box.scene->getStatistics().solves;
    box.viewer.frames(20);
    EXPECT_EQ(box.scene->getStatistics().solves, solves); // the hand rests
    box.scene->setReach(0.0);
    EXPECT_TRUE(box.viewer.framesUntil([&] { return box.points() == all; }));
}

TEST(Hands, ARecordingNamedInTheSettingsIsPlayed)
{
    const std::string file = testing::TempDir() + "midair-touch.csv";
    {
        std::vector<midair::bridge::HandFrame> frames;
        for (const double time : {0.0, 0.2, 0.4})
        {
            midair::bridge::HandFrame frame;
            frame.time_s = time;
            const double gap = time == 0.2 ? -0.003 : 0.02;
            frame.hands.push_back(midair::bridge::openHandWithIndexTipAt(
                1, Eigen::Vector3d(0, 0, 0.1775 + gap), Eigen::Quaterniond::Identity()));
            for (std::size_t i = 0; i < Hand::kJoints; ++i)
                frame.hands[0].joints[i].positionValid = i == 9 || i == 10;
            frames.push_back(frame);
        }
        std::ofstream out(file);
        midair::bridge::writeHandRecording(out, frames);
    }
    TouchedBox box;
    box.scene->setHandSource(nullptr);
    box.scene->setHands("recorded:" + file);
    const auto frameAt = [&](double time)
    {
        box.viewer.viewer.advance(time);
        box.viewer.viewer.eventTraversal();
        box.viewer.viewer.updateTraversal();
    };
    // The file is read on a thread of its own, which may take longer than all frames here.
    ASSERT_TRUE(eventually(
        [&]
        {
            frameAt(5.0);
            return box.scene->getStatistics().hands > 0;
        }));
    for (double time = 5.0; time < 5.5; time += 0.01)
        frameAt(time);
    ASSERT_EQ(box.diary->lines, (std::vector<std::string>{"enter box", "leave box"}));
    // 23 mm in 0.2 s, through 0 after 20/23 of it and past 4 mm after 7/23; frames of 10 ms.
    EXPECT_NEAR(box.diary->touches[0].time - 5.0, 0.2 * 20.0 / 23.0, 0.0101);
    EXPECT_NEAR(box.diary->touches[1].time - 5.0, 0.2 + 0.2 * 7.0 / 23.0, 0.0101);
}

TEST(Hands, AWrongSourceIsSaidOnce)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    box.scene->setHands("telepathy:");
    viewer.frames(5);
    const auto messages = box.scene->getStatistics().messages;
    const std::string wrong = "hand source \"telepathy:\" is not known; recorded:FILE, ";
    EXPECT_EQ(std::count_if(messages.begin(),
                            messages.end(),
                            [&](const std::string& one) { return one.rfind(wrong, 0) == 0; }),
              1);
}

TEST(MouseHand, FingerFollowsTheMouseInItsPlane)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    const osg::ref_ptr<MouseHand> mouse = new MouseHand(0.001, osg::Vec3d(0, 0, 150));
    viewer.viewer.addEventHandler(mouse);
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0, -500, 150), osg::Vec3d(0, 0, 150), osg::Vec3d(0, 0, 1));
    viewer.viewer.getCamera()->setProjectionMatrixAsPerspective(30.0, 1.0, 1.0, 2000.0);
    std::vector<Hand> hands;
    EXPECT_FALSE(mouse->getHandSource()->getHands(0.0, hands));
    const osg::ref_ptr<osgGA::GUIEventAdapter> event = new osgGA::GUIEventAdapter;
    event->setEventType(osgGA::GUIEventAdapter::MOVE);
    event->setInputRange(-1, -1, 1, 1);
    event->setMouseYOrientation(osgGA::GUIEventAdapter::Y_INCREASING_UPWARDS);
    event->setX(0.5);
    event->setY(0.25);
    mouse->handle(*event, viewer.viewer);
    ASSERT_TRUE(mouse->getHandSource()->getHands(0.0, hands));
    // At 500 mm the picture is 500 tan 15 degrees = 134 mm high and wide to each side.
    const osg::Vec3d tip = hands[0].joints[10].position;
    EXPECT_LT((tip - osg::Vec3d(0.067, 0.0, 0.15 + 0.0335)).length(), 1e-4);
    // Fingers point away from the viewer: the wrist is nearer to it.
    EXPECT_LT(hands[0].joints[1].position.y(), -0.08);
    EXPECT_GT(hands[0].joints[1].position.x(), tip.x() + 0.05) << "at the right, not before it";
    event->setEventType(osgGA::GUIEventAdapter::KEYDOWN);
    event->setKey('t');
    mouse->handle(*event, viewer.viewer);
    EXPECT_FALSE(mouse->getHandSource()->getHands(0.0, hands));
}

TEST(RigidBodyCallback, ABodyDrivesWhatIsFelt)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity(btVector3(0, 0, 0));
    btSphereShape sphere(btScalar(0.02));
    btRigidBody body(
        btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &sphere, btVector3(1, 1, 1)));
    btTransform start;
    start.setIdentity();
    start.setOrigin(btVector3(0, 0, btScalar(0.15)));
    body.setWorldTransform(start);
    body.setLinearVelocity(btVector3(btScalar(0.1), 0, 0));
    world.addRigidBody(&body);
    {
        BoxScene box;
        const osg::ref_ptr<RigidBodyWorld> stepped = new RigidBodyWorld(world);
        box.transform->setUpdateCallback(new RigidBodyCallback(stepped, body));
        HeadlessViewer viewer(box.scene);
        for (double time = 0.0; time <= 0.2001; time += 0.02)
        {
            viewer.viewer.advance(time);
            viewer.viewer.eventTraversal();
            viewer.viewer.updateTraversal();
        }
        EXPECT_EQ(stepped->getNumSteps(), 48u);
        // 0.1 m/s for 0.2 s less the one step that the pose lags.
        EXPECT_NEAR(box.transform->getMatrix().getTrans().x(), 0.02 - 0.1 / 240.0, 1e-5);
    }
    world.removeRigidBody(&body);
}
