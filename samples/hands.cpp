// Sample without a window: a finger touches a box that a Bullet body carries through the array.
// Prints touches, and the points that are solved for near the hand, with its shadow. With a hand
// recording as argument it plays that instead.

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/RigidBodyCallback>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace
{

constexpr double kFrame_s = 1.0 / 60.0;
constexpr double kEnd_s = 2.0;
constexpr double kHalfEdge_m = 0.02;

class PrintTouches : public osgMidair::TouchCallback
{
public:
    void enter(const osgMidair::Touch& touch) override { print("enter", touch); }
    void leave(const osgMidair::Touch& touch) override { print("leave", touch); }

protected:
    ~PrintTouches() override = default;

private:
    static void print(const char* what, const osgMidair::Touch& touch)
    {
        std::printf(
            "%5.2f s  %s %s with the bone %s of hand %d: %.1f mm, %.0f mm^2, up to %.2f mN\n",
            touch.time,
            what,
            touch.node ? touch.node->getName().c_str() : "what is gone",
            touch.bone.c_str(),
            touch.hand,
            1e3 * touch.distance,
            1e6 * touch.area,
            1e3 * touch.force);
    }
};

/// A weightless body that drifts along x and turns.
struct Physics
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btBoxShape box{btVector3(btScalar(kHalfEdge_m), btScalar(kHalfEdge_m), btScalar(kHalfEdge_m))};
    btRigidBody body{
        btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &box, btVector3(1, 1, 1))};

    Physics()
    {
        world.setGravity(btVector3(0, 0, 0));
        body.setLinearVelocity(btVector3(btScalar(0.01), 0, 0));
        body.setAngularVelocity(btVector3(0, 0, btScalar(0.5)));
        body.setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(&body);
    }
    ~Physics() { world.removeRigidBody(&body); }
};

/// Returns a hand, tilted down with all fingers stretched, whose index finger taps on the box from
/// above once a second.
osgMidair::Hand tapping(double time_s)
{
    const double height = kHalfEdge_m + 0.0075 + 0.012 * std::cos(2.0 * M_PI * time_s) + 0.010;
    return osgMidair::openHand(
        1, osg::Vec3d(0.01, 0.0, height), osg::Quat(-M_PI / 6.0, osg::Vec3d(1, 0, 0)));
}

void printField(const osgMidair::HapticScene& scene, double boxX_m, double time_s)
{
    const osgMidair::HapticStatistics figures = scene.getStatistics();
    if (figures.solves == 0) return;
    std::printf("%5.2f s  box at x = %.1f mm: %d points solved; error %.2f %%, %.0f Pa\n",
                time_s,
                1e3 * boxX_m,
                figures.points,
                100.0 * figures.rms,
                figures.level_Pa);
}

} // namespace

int main(int argc, char** argv)
{
    Physics physics;
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    const osg::ref_ptr<osgMidair::HapticSurface> surface = new osgMidair::HapticSurface;
    surface->setName("box");
    surface->setTouchEvents(true);
    surface->addChild(
        new osg::ShapeDrawable(new osg::Box(osg::Vec3(), static_cast<float>(2.0 * kHalfEdge_m))));
    const osg::ref_ptr<osg::MatrixTransform> carried = new osg::MatrixTransform;
    carried->setUpdateCallback(new osgMidair::RigidBodyCallback(
        new osgMidair::RigidBodyWorld(physics.world), physics.body));
    carried->addChild(surface);
    scene->addChild(carried);

    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    if (argc > 1)
        scene->setHands(std::string("recorded:") + argv[1]);
    else
        scene->setHandSource(hands);
    scene->setTouchCallback(new PrintTouches);
    scene->setReach(0.015);
    scene->setShadows(true);

    osgViewer::Viewer viewer;
    viewer.setUpViewerAsEmbeddedInWindow(
        0, 0, 64, 64); // a viewer without a window counts as closed; nothing is drawn
    viewer.setSceneData(scene);
    int frame = 0;
    for (double time_s = 0.0; time_s < kEnd_s; time_s = kFrame_s * ++frame)
    {
        hands->setHands({tapping(time_s)});
        viewer.advance(time_s);
        viewer.eventTraversal();
        viewer.updateTraversal();
        if (frame % 15 == 0) printField(*scene, carried->getMatrix().getTrans().x(), time_s);
        std::this_thread::sleep_for(std::chrono::duration<double>(kFrame_s));
    }
    const osgMidair::HapticStatistics statistics = scene->getStatistics();
    std::printf("%llu frames, %llu solves, %llu points were out of reach of the hand\n",
                static_cast<unsigned long long>(statistics.frames),
                static_cast<unsigned long long>(statistics.solves),
                static_cast<unsigned long long>(statistics.outOfReach));
    return statistics.solves > 0 ? 0 : 1;
}
