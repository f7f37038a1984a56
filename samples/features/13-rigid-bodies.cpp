// Rigid bodies: a Bullet box drifts through the array, is felt at its place, and is pushed by a
// hand. The hand's bones are bodies of the same world; a push counts as a touch.

#include "Frames.h"

#include <osgMidair/HandBodies>
#include <osgMidair/HapticSurface>
#include <osgMidair/RigidBodyCallback>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

int main()
{
    constexpr double kHalfEdge_m = 0.02;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity(btVector3(0, 0, 0));
    btBoxShape shape(btVector3(1, 1, 1) * btScalar(kHalfEdge_m));
    btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(0.1F, nullptr, &shape, {1, 1, 1}));
    body.setActivationState(DISABLE_DEACTIVATION);
    body.setLinearVelocity(btVector3(btScalar(0.02), 0, 0)); // m/s
    world.addRigidBody(&body);

    const osg::ref_ptr<osg::MatrixTransform> carried = new osg::MatrixTransform;
    carried->setUpdateCallback(
        new osgMidair::RigidBodyCallback(new osgMidair::RigidBodyWorld(world), body));
    const osg::ref_ptr<osgMidair::HapticSurface> surface = new osgMidair::HapticSurface(
        new osg::ShapeDrawable(new osg::Box(osg::Vec3(), static_cast<float>(2.0 * kHalfEdge_m))));
    surface->setTouchEvents(true);
    carried->addChild(surface);
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(carried);
    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    scene->setHandSource(hands);
    scene->addUpdateCallback(new osgMidair::HandBodies(world, scene));

    // A hand comes down on the box after one second.
    const auto push = [&hands](double time_s)
    {
        const double height_m = kHalfEdge_m + 0.02 - 0.04 * std::max(0.0, time_s - 1.0);
        if (time_s < 1.0) return;
        hands->setHands({osgMidair::openHand(
            1, osg::Vec3d(0.02, 0, height_m), osg::Quat(-osg::PI / 2.0, osg::Vec3d(1, 0, 0)))});
    };
    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    for (int i = 0; i < 4; ++i)
    {
        frames.run(0.5, push);
        const osg::Vec3d place = carried->getMatrix().getTrans();
        std::printf("box at x = %+.1f mm, z = %+.1f mm, %d points, %s\n",
                    1e3 * place.x(),
                    1e3 * place.z(),
                    scene->getStatistics().points,
                    scene->getTouches().empty() ? "not touched" : "touched");
    }
    std::printf("%s\n", body.getLinearVelocity().z() < 0 ? "pushed down" : "not pushed");
    world.removeRigidBody(&body);
    return 0;
}
