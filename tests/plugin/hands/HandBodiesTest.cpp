#include "tests/plugin/KitTest.h"

#include <osgMidair/HandBodies>
#include <osgMidair/RigidBodyCallback>
#include <osgMidair/TouchCallback>

#include <algorithm>
#include <utility>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

using namespace osgMidair;

TEST(HandBodies, TheHandsOfASceneAreBodiesOfTheWorld)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    BoxScene box;
    const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    const osg::ref_ptr<HandBodies> bodies = new HandBodies(world, box.scene.get());
    box.scene->addUpdateCallback(bodies);
    HeadlessViewer viewer(box.scene);
    viewer.frame();
    EXPECT_EQ(bodies->getNumBodies(), 0);
    box.scene->setHandSource(hands);
    hands->setHands({openHand(0, osg::Vec3d(0.0, 0.0, 0.2), osg::Quat())});
    viewer.frame();
    EXPECT_EQ(bodies->getNumBodies(), 24);
    ASSERT_EQ(world.getNumCollisionObjects(), 24);
    int hand = -1;
    int bone = -1;
    EXPECT_TRUE(bodies->getBone(*world.getCollisionObjectArray()[5], hand, bone));
    EXPECT_EQ(hand, 0);
    EXPECT_EQ(bone, 5);
    hands->setHands({});
    EXPECT_TRUE(viewer.framesUntil([&] { return bodies->getNumBodies() == 0; }));
    EXPECT_EQ(world.getNumCollisionObjects(), 0);
}

namespace
{

/// Counts what is told of touches.
struct Counter : TouchCallback
{
    void enter(const Touch&) override { ++enters; }
    void stay(const Touch& touch) override
    {
        ++stays;
        force_N = std::max(force_N, touch.force);
    }
    void leave(const Touch&) override { ++leaves; }

    int enters = 0;
    int stays = 0;
    int leaves = 0;
    double force_N = 0.0;
};

/// A ball of Bullet's that moves along x alone, as the haptic object of a scene, and the last bone
/// of an index finger, in a viewer whose frames come each 1/60 s of simulated time.
class PushedBall
{
public:
    PushedBall()
    {
        world.setGravity(btVector3(0, 0, 0));
        btTransform start;
        start.setIdentity();
        start.setOrigin(btVector3(0, 0, btScalar(0.15)));
        body.setWorldTransform(start);
        body.setActivationState(DISABLE_DEACTIVATION);
        body.setLinearFactor(btVector3(1, 0, 0));
        body.setAngularFactor(0);
        world.addRigidBody(&body);
        box.surface->removeChildren(0, box.surface->getNumChildren());
        box.surface->addChild(
            new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), static_cast<float>(kRadius_m))));
        box.surface->setTouchEvents(true);
        box.surface->setTouchCallback(told);
        box.transform->setUpdateCallback(new RigidBodyCallback(new RigidBodyWorld(world), body));
        box.scene->setHandSource(hands);
        box.scene->addUpdateCallback(new HandBodies(world, box.scene.get()));
    }
    ~PushedBall()
    {
        viewer.viewer.setSceneData(nullptr);
        box.scene = nullptr;
        world.removeRigidBody(&body);
    }

    /// A frame with the finger's skin \a gap_m from where the ball was at first.
    void frame(double gap_m)
    {
        Hand hand;
        hand.id = 1;
        for (const auto& [joint, y] : {std::pair(9, -0.01), {10, 0.01}}) // index distal and tip
        {
            HandJoint& itsJoint = hand.joints[joint];
            itsJoint.position = osg::Vec3d(-kRadius_m - 0.008 - gap_m, y, 0.15);
            itsJoint.radius = 0.008;
            itsJoint.positionValid = true;
        }
        hands->setHands({hand});
        viewer.viewer.advance(++frames / 60.0);
        viewer.viewer.eventTraversal();
        viewer.viewer.updateTraversal();
    }

    static constexpr double kRadius_m = 0.02;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btSphereShape sphere{btScalar(kRadius_m)};
    btRigidBody body{
        btRigidBody::btRigidBodyConstructionInfo(btScalar(0.1), nullptr, &sphere, {1, 1, 1})};
    BoxScene box;
    const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    const osg::ref_ptr<Counter> told = new Counter;
    HeadlessViewer viewer{box.scene};
    int frames = 0;
};

} // namespace

// The ball goes ahead at the finger's speed: their distance may stay above 0.
TEST(HandBodies, WhatHandsPushIsTouched)
{
    for (const double speed_mps : {0.05, 0.1, 0.3, 1.0})
    {
        PushedBall ball;
        const int most = std::min(static_cast<int>(0.06 / speed_mps * 60.0), 40);
        for (int i = 0; i < most; ++i)
            ball.frame(0.0151 - speed_mps * i / 60.0);
        ASSERT_GT(ball.body.getLinearVelocity().x(), 0.5 * speed_mps) << "it was pushed";
        EXPECT_EQ(ball.told->enters, 1) << speed_mps;
        EXPECT_EQ(ball.told->leaves, 0) << speed_mps;
        EXPECT_GT(ball.told->stays, 0) << speed_mps;
    }
}

// A ball that rests on a finger: it presses as long as it does, whole or as a contact.
TEST(HandBodies, WhatRestsOnAHandIsFelt)
{
    for (const auto render : {HapticSettings::OBJECT, HapticSettings::CONTACT})
    {
        PushedBall ball;
        ball.world.setGravity(btVector3(btScalar(-9.81), 0, 0));
        ball.box.scene->setRender(render);
        EXPECT_TRUE(eventually(
            [&]
            {
                ball.frame(0.0002);
                return ball.told->force_N > 0.0 &&
                       (render == HapticSettings::OBJECT ||
                        ball.box.scene->getStatistics().contactFields > 0);
            }))
            << render;
        EXPECT_EQ(ball.told->enters, 1);
        EXPECT_EQ(ball.told->leaves, 0);
    }
}
