#include "engine-bridge/bodies/RigidBodyStepper.h"

#include <osg/FrameStamp>
#include <osg/MatrixTransform>
#include <osg/PositionAttitudeTransform>
#include <osgUtil/UpdateVisitor>

#include <cmath>
#include <random>
#include <stdexcept>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

/// A tumbling box of 40 mm that falls on a floor and bounces there.
struct Fall
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btBoxShape box{btVector3(btScalar(0.02), btScalar(0.02), btScalar(0.02))};
    btStaticPlaneShape plane{btVector3(0, 0, 1), 0};
    btRigidBody body{
        btRigidBody::btRigidBodyConstructionInfo(btScalar(0.1), nullptr, &box, inertia())};
    btRigidBody floor{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane)};

    explicit Fall(bool withFloor = true)
    {
        world.setGravity(btVector3(0, 0, btScalar(-9.81)));
        body.setRestitution(btScalar(0.6));
        floor.setRestitution(btScalar(0.8));
        btTransform start;
        start.setIdentity();
        start.setOrigin(btVector3(0, 0, btScalar(0.3)));
        body.setWorldTransform(start);
        body.setAngularVelocity(btVector3(3, 2, 1));
        body.setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(&body);
        if (withFloor) world.addRigidBody(&floor);
    }
    ~Fall()
    {
        if (floor.isInWorld()) world.removeRigidBody(&floor);
        world.removeRigidBody(&body);
    }

    btVector3 inertia() const
    {
        btVector3 result;
        box.calculateLocalInertia(btScalar(0.1), result);
        return result;
    }
};

/// Runs to \a end_s with frames of \a mean_s, each up to \a jitter of it early or late.
Eigen::Matrix4d poseAfter(double end_s, double mean_s, double jitter, std::uint64_t seed)
{
    Fall fall;
    const osg::ref_ptr<RigidBodyStepper> stepper = new RigidBodyStepper(fall.world);
    stepper->track(fall.body);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(1.0 - jitter, 1.0 + jitter);
    stepper->advanceTo(0.0);
    for (double time = 0.0; time < end_s; time += mean_s * uniform(random))
        stepper->advanceTo(time);
    stepper->advanceTo(end_s);
    return stepper->pose(fall.body).matrix();
}

TEST(RigidBodyStepper, PoseDependsOnTimeAloneWhateverTheFrames)
{
    // After 1.2 s the box has bounced several times, so that any difference would have grown.
    const Eigen::Matrix4d expected = poseAfter(1.2, 1.0 / 60.0, 0.0, 0);
    for (const double mean : {1.0 / 30.0, 1.0 / 90.0, 1.0 / 500.0})
        for (std::uint64_t seed = 1; seed < 4; ++seed)
            EXPECT_EQ(poseAfter(1.2, mean, 0.9, seed), expected)
                << mean << " " << seed; // bit for bit
}

TEST(RigidBodyStepper, FreeFallIsThatOfTheStepsAndInterpolatedBetween)
{
    Fall fall(false);
    StepperOptions options;
    options.step_s = 0.01;
    options.catchUp_s = 1.0;
    const osg::ref_ptr<RigidBodyStepper> stepper = new RigidBodyStepper(fall.world, options);
    stepper->track(fall.body);
    stepper->advanceTo(100.0); // where time begins
    stepper->advanceTo(100.205);
    EXPECT_EQ(stepper->steps(), 20u);
    // Symplectic Euler after n steps: z0 - g h^2 n (n + 1) / 2; the pose lags a step: halfway
    // between 19 and 20.
    const auto fallen = [](int n) { return 9.81 * 1e-4 * n * (n + 1) / 2.0; };
    const double expected = 0.3 - 0.5 * (fallen(19) + fallen(20));
    EXPECT_NEAR(
        stepper->pose(fall.body).translation().z(), expected, 2e-6); // Bullet's floats, 20 steps
    stepper->untrack(fall.body);
    EXPECT_NEAR(stepper->pose(fall.body).translation().z(), 0.3 - fallen(20), 2e-6);
}

TEST(RigidBodyStepper, ALongPauseIsDroppedAndCounted)
{
    Fall fall;
    const osg::ref_ptr<RigidBodyStepper> stepper = new RigidBodyStepper(fall.world);
    stepper->advanceTo(0.0);
    stepper->advanceTo(10.0);
    EXPECT_EQ(stepper->steps(), 60u); // a quarter of a second
    EXPECT_NEAR(stepper->dropped_s(), 9.75, 1e-9);
    stepper->advanceTo(10.0 + 1.0 / 240.0);
    EXPECT_EQ(stepper->steps(), 61u);
}

TEST(RigidBodyStepper, TimeThatGoesBackBeginsAnew)
{
    Fall fall;
    const osg::ref_ptr<RigidBodyStepper> stepper = new RigidBodyStepper(fall.world);
    stepper->advanceTo(5.0);
    stepper->advanceTo(5.1);
    EXPECT_EQ(stepper->steps(), 24u);
    stepper->advanceTo(0.0);
    stepper->advanceTo(NAN);
    EXPECT_EQ(stepper->steps(), 24u);
    stepper->advanceTo(0.1);
    EXPECT_EQ(stepper->steps(), 48u);
}

TEST(RigidBodyStepper, WrongOptionsAreNamed)
{
    Fall fall;
    StepperOptions options;
    options.step_s = 0.0;
    try
    {
        const osg::ref_ptr<RigidBodyStepper> stepper = new RigidBodyStepper(fall.world, options);
        FAIL();
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_STREQ(error.what(), "StepperOptions: step_s is 0; it must be above 0");
    }
}

/// A scene whose root is scaled to millimetres and turned, with \a driven below it.
struct Scene
{
    Fall fall;
    osg::ref_ptr<RigidBodyStepper> stepper = new RigidBodyStepper(fall.world);
    osg::ref_ptr<osg::MatrixTransform> root = new osg::MatrixTransform;
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    osgUtil::UpdateVisitor update;

    Scene()
    {
        root->setMatrix(osg::Matrixd::rotate(0.7, osg::Vec3d(1, 2, 3)) *
                        osg::Matrixd::translate(5, 6, 7));
        update.setFrameStamp(stamp);
    }

    void frame(double time_s)
    {
        stamp->setSimulationTime(time_s);
        update.setTraversalNumber(update.getTraversalNumber() + 1);
        root->accept(update);
    }
};

void expectWorld(const osg::Node& node,
                 const RigidBodyStepper& stepper,
                 const btRigidBody& body,
                 double scale)
{
    const osg::Matrixd world = node.getWorldMatrices().at(0);
    const Eigen::Isometry3d pose = stepper.pose(body);
    for (const Eigen::Vector3d& model : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 2, 3)})
    {
        const osg::Vec3d seen = osg::Vec3d(model.x(), model.y(), model.z()) * world;
        const Eigen::Vector3d expected = pose * (0.001 * scale * model) * 1000.0; // in millimetres
        EXPECT_LT((Eigen::Vector3d(seen.x(), seen.y(), seen.z()) - expected).norm(), 1e-9);
    }
}

TEST(RigidBodyPose, DrivesTransformsBelowAMovedRoot)
{
    Scene scene;
    const osg::ref_ptr<osg::MatrixTransform> matrix = new osg::MatrixTransform;
    const osg::ref_ptr<osg::PositionAttitudeTransform> placed = new osg::PositionAttitudeTransform;
    placed->setScale(osg::Vec3d(3, 3, 3));
    scene.root->addChild(matrix);
    scene.root->addChild(placed);
    const osg::Matrixd twice = osg::Matrixd::scale(2, 2, 2);
    matrix->setUpdateCallback(new RigidBodyPose(scene.stepper, scene.fall.body, 1e-3, twice));
    placed->setUpdateCallback(new RigidBodyPose(scene.stepper, scene.fall.body, 1e-3));
    scene.frame(0.0);
    expectWorld(*matrix, *scene.stepper, scene.fall.body, 2.0);
    scene.frame(0.1234);
    EXPECT_EQ(scene.stepper->steps(), 29u); // stepped once, though two callbacks ran
    expectWorld(*matrix, *scene.stepper, scene.fall.body, 2.0);
    expectWorld(*placed, *scene.stepper, scene.fall.body, 3.0);
    EXPECT_LT(scene.stepper->pose(scene.fall.body).translation().z(), 0.29);
}

TEST(RigidBodyPose, LetsGoOfTheBodyWithTheNode)
{
    Scene scene;
    osg::ref_ptr<osg::MatrixTransform> matrix = new osg::MatrixTransform;
    matrix->setUpdateCallback(new RigidBodyPose(scene.stepper, scene.fall.body));
    scene.root->addChild(matrix);
    scene.frame(0.0);
    scene.frame(0.1);
    scene.root->removeChild(matrix);
    EXPECT_EQ(scene.stepper->referenceCount(), 2);
    matrix = nullptr;
    EXPECT_EQ(scene.stepper->referenceCount(), 1);
}

} // namespace

} // namespace midair::bridge
