#include "tests/plugin/KitTest.h"

#include <osgMidair/HandBodies>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
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
