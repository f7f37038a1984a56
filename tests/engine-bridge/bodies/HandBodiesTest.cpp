#include "engine-bridge/bodies/HandBodies.h"

#include <cmath>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

/// A weightless ball of 10 mm at the origin.
struct World
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btSphereShape sphere{btScalar(0.01)};
    btRigidBody ball{btRigidBody::btRigidBodyConstructionInfo(
        btScalar(0.01), nullptr, &sphere, btVector3(1e-6f, 1e-6f, 1e-6f))};

    World()
    {
        world.setGravity(btVector3(0, 0, 0));
        ball.setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(&ball);
    }
    ~World() { world.removeRigidBody(&ball); }
};

/// The last bone of an index finger along y, its middle at \a x.
HandFrame bone(double x, double time_s, int id = 1)
{
    HandFrame frame;
    frame.time_s = time_s;
    Hand hand;
    hand.id = id;
    for (const auto& [joint, y] : {std::pair(INDEX_DISTAL, -0.01), {INDEX_TIP, 0.01}})
    {
        hand.joints[joint].position = Eigen::Vector3d(x, y, 0.0);
        hand.joints[joint].radius_m = 0.008;
        hand.joints[joint].positionValid = true;
    }
    frame.hands.push_back(hand);
    return frame;
}

} // namespace

TEST(HandBodies, AFingerPushesABallAtItsOwnSpeed)
{
    // Once with single steps of 1/240 s, once with one call a frame.
    for (const int steps : {4, 1})
    {
        World world;
        HandBodies bodies(world.world);
        constexpr double kSpeed_mps = 0.1;
        for (int frame = 0; frame < 30; ++frame)
        {
            bodies.update(bone(-0.025 + kSpeed_mps * frame / 60.0, frame / 60.0), steps);
            ASSERT_EQ(bodies.count(), 1);
            if (steps == 1) world.world.stepSimulation(btScalar(1.0 / 60.0), 0);
            for (int step = 0; steps > 1 && step < steps; ++step)
                world.world.stepSimulation(btScalar(1.0 / 240.0), 0);
        }
        // The finger's skin is at 31 mm or so: the ball is beyond it, and was not shot away.
        const double ball = world.ball.getWorldTransform().getOrigin().x();
        EXPECT_GT(ball, 0.025 + 0.01) << steps;
        EXPECT_LT(ball, 0.06) << steps;
        EXPECT_NEAR(world.ball.getLinearVelocity().x(), kSpeed_mps, 0.4 * kSpeed_mps) << steps;
    }
}

TEST(HandBodies, WhatAFingerPushesIsToldWithItsForce)
{
    World world;
    constexpr double kDamping = 0.9; // of the speed in a second
    constexpr double kSpeed_mps = 0.1;
    world.ball.setDamping(btScalar(kDamping), 0);
    HandBodies bodies(world.world);
    EXPECT_TRUE(bodies.presses().empty());
    for (int frame = 0; frame < 30; ++frame)
    {
        bodies.presses();
        bodies.update(bone(-0.025 + kSpeed_mps * frame / 60.0, frame / 60.0), 4);
        for (int step = 0; step < 4; ++step)
            world.world.stepSimulation(btScalar(1.0 / 240.0), 0);
    }
    const std::vector<HandPress> presses = bodies.presses();
    ASSERT_EQ(presses.size(), 1u);
    EXPECT_EQ(presses[0].hand, 1);
    EXPECT_EQ(boneName(presses[0].bone), "index distal to index tip");
    // The body loses m v ln(1 / (1 - d)) a second.
    const double wanted_N = 0.01 * kSpeed_mps * -std::log(1.0 - kDamping);
    EXPECT_NEAR(presses[0].force_N, wanted_N, 0.1 * wanted_N);
    const btVector3 ball = world.ball.getWorldTransform().getOrigin();
    EXPECT_NEAR(presses[0].place.x(), ball.x() - 0.01, 1e-3);
    EXPECT_NEAR(presses[0].place.z(), 0.0, 1e-3);
    EXPECT_EQ(bodies.presses().size(), 1u) << "as long as no step has come";
    world.world.removeRigidBody(&world.ball);
    world.world.stepSimulation(btScalar(1.0 / 240.0), 0);
    EXPECT_TRUE(bodies.presses().empty());
    world.world.addRigidBody(&world.ball);
}

TEST(HandBodies, ABodyIsWhereItsBoneIsAndIsFound)
{
    World world;
    HandBodies bodies(world.world);
    bodies.update(bone(-0.1, 0.0));
    bodies.update(bone(-0.09, 0.1));
    world.world.stepSimulation(btScalar(1.0 / 240.0), 0);
    const btCollisionObject* body = world.world.getCollisionObjectArray()[1];
    EXPECT_NEAR(body->getWorldTransform().getOrigin().x(), -0.09, 1e-6);
    btVector3 low;
    btVector3 high;
    body->getCollisionShape()->getAabb(body->getWorldTransform(), low, high);
    EXPECT_NEAR(high.y(), 0.018, 1e-3);
    int hand = -1;
    int found = -1;
    EXPECT_TRUE(bodies.find(*body, hand, found));
    EXPECT_EQ(hand, 1);
    EXPECT_EQ(boneName(found), "index distal to index tip");
    EXPECT_FALSE(bodies.find(world.ball, hand, found));
    EXPECT_TRUE(body->isKinematicObject());
}

TEST(HandBodies, ALostHandIsTakenOutAfterAMoment)
{
    World world;
    {
        HandBodies bodies(world.world);
        bodies.update(bone(-0.1, 1.0));
        HandFrame lost;
        lost.time_s = 1.09;
        bodies.update(lost);
        EXPECT_EQ(bodies.count(), 1);
        lost.time_s = 1.11;
        bodies.update(lost);
        EXPECT_EQ(bodies.count(), 0);
        EXPECT_EQ(world.world.getNumCollisionObjects(), 1);
        bodies.update(bone(-0.1, 1.2));
        EXPECT_EQ(world.world.getNumCollisionObjects(), 2);
        HandFrame before; // a recording that begins again
        bodies.update(before);
        EXPECT_EQ(bodies.count(), 0);
        bodies.update(bone(-0.1, 0.1));
    }
    EXPECT_EQ(world.world.getNumCollisionObjects(), 1) << "all are taken out at the end";
}

TEST(HandBodies, AJumpIsNoPush)
{
    World world;
    HandBodies bodies(world.world);
    bodies.update(bone(-0.5, 0.0));
    world.world.stepSimulation(btScalar(1.0 / 240.0), 0);
    bodies.update(bone(0.5, 0.02), 4); // through the ball
    for (int step = 0; step < 8; ++step)
        world.world.stepSimulation(btScalar(1.0 / 240.0), 0);
    EXPECT_EQ(world.ball.getLinearVelocity().length(), 0);
    EXPECT_EQ(bodies.count(), 1);
}

TEST(HandBodies, ABoneThatGrowsGetsANewShape)
{
    World world;
    HandBodies bodies(world.world);
    bodies.update(bone(-0.1, 0.0));
    HandFrame thick = bone(-0.1, 0.1);
    for (HandJoint& joint : thick.hands[0].joints)
        joint.radius_m = joint.positionValid ? 0.012 : 0.0;
    bodies.update(thick);
    ASSERT_EQ(world.world.getNumCollisionObjects(), 2);
    const btCollisionObject* body = world.world.getCollisionObjectArray()[1];
    btVector3 low;
    btVector3 high;
    body->getCollisionShape()->getAabb(body->getWorldTransform(), low, high);
    EXPECT_NEAR(high.x() - low.x(), 0.024, 2e-3);
}

} // namespace midair::bridge
