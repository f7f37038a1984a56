#pragma once

#include <osgMidair/HandBodies>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/RigidBodyCallback>

#include <osg/MatrixTransform>

#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace midair::samples
{

/// A ball or a cube that bounces, is pushed and is felt.
struct Toy
{
    std::string name;
    std::unique_ptr<btCollisionShape> shape;
    std::unique_ptr<btRigidBody> body;
    osg::ref_ptr<osgMidair::HapticSurface> surface;
    bool isPushed = false;     ///< a hand pushes it now
    std::uint64_t pushes = 0;  ///< times that a hand began to push it
    std::uint64_t touches = 0; ///< times that a finger began to touch it
    double force_N = 0.0;      ///< the largest
    double way_m = 0.0;        ///< how far it has gone while a hand pushed it
    osg::Vec3d last;
};

/// Toys in a box with a floor, walls and a lid, in a Bullet world that hands push.
class Toys
{
public:
    /// Half of the box's inside, m.
    static constexpr double kHalfWidth_m = 0.075;
    static constexpr double kHalfDepth_m = 0.05;
    static constexpr double kHalfHeight_m = 0.06;

    /// Adds the toys to \a scene. \a gravity: m/s^2.
    Toys(osgMidair::HapticScene& scene, double gravity, std::uint32_t seed);
    ~Toys();
    Toys(const Toys&) = delete;
    Toys& operator=(const Toys&) = delete;

    /// Looks who is pushed, brings back what has left the box, and tosses one up if \a tosses.
    void update(bool tosses);

    std::vector<Toy>& all() { return _toys; }
    const std::vector<Toy>& all() const { return _toys; }
    Toy* find(const osg::Node* surface);
    std::uint64_t tosses() const { return _tossed; }
    std::uint64_t returns() const { return _returned; }
    int handBodies() const { return _hands->getNumBodies(); }

private:
    void addWalls();
    void add(osgMidair::HapticScene& scene, bool isBall, double half_m, int number);
    void follow(Toy& toy);

    btDefaultCollisionConfiguration _configuration;
    btCollisionDispatcher _dispatcher{&_configuration};
    btDbvtBroadphase _broadphase;
    btSequentialImpulseConstraintSolver _solver;
    btDiscreteDynamicsWorld _world{&_dispatcher, &_broadphase, &_solver, &_configuration};
    std::vector<std::unique_ptr<btCollisionShape>> _wallShapes;
    std::vector<std::unique_ptr<btRigidBody>> _walls;
    std::vector<Toy> _toys;
    osg::ref_ptr<osgMidair::RigidBodyWorld> _steps;
    osg::ref_ptr<osgMidair::HandBodies> _hands;
    std::mt19937 _lot;
    std::uint64_t _tossed = 0;
    std::uint64_t _returned = 0;
};

} // namespace midair::samples
