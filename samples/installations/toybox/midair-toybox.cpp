/// Toys that bounce in the array and can be pushed and felt.
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"

#include <osgMidair/HandBodies>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/RigidBodyCallback>

#include <osg/MatrixTransform>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <fmt/format.h>

namespace
{

using namespace midair::samples;
using namespace midair;

/// A bouncing ball or cube.
struct Toy
{
    std::string name;
    std::unique_ptr<btCollisionShape> shape;
    std::unique_ptr<btRigidBody> body;
    osg::ref_ptr<osgMidair::HapticSurface> surface;
    bool isPushed = false;     ///< a hand is pushing it
    std::uint64_t pushes = 0;  ///< number of pushes
    std::uint64_t touches = 0; ///< number of touches by fingers
    double force_N = 0.0;      ///< largest force
    double way_m = 0.0;        ///< distance moved while being pushed
    osg::Vec3d last;
};

/// Inset of a body's collision shape: a pushing finger penetrates the haptic surface by this much
/// and so feels the push.
constexpr double kWithin_m = 0.002;
constexpr double kMass_kg = 0.02;
constexpr double kRestitution = 0.8;
constexpr double kWall_m = 0.05; ///< half thickness

btVector3 bulletVector(double x, double y, double z)
{
    return {btScalar(x), btScalar(y), btScalar(z)};
}

osg::Vec3d placeOf(const btRigidBody& body)
{
    const btVector3& p = body.getWorldTransform().getOrigin();
    return {p.x(), p.y(), p.z()};
}

/// Toys in a box with floor, walls and lid, simulated by Bullet and pushed by hands.
class Toys
{
public:
    /// Half of the box's inner size, m.
    static constexpr double kHalfWidth_m = 0.075;
    static constexpr double kHalfDepth_m = 0.05;
    static constexpr double kHalfHeight_m = 0.06;

    /// Adds the toys to \a scene. \a gravity: m/s^2.
    Toys(osgMidair::HapticScene& scene, double gravity, std::uint32_t seed) :
        _steps(new osgMidair::RigidBodyWorld(_world)),
        _hands(new osgMidair::HandBodies(_world, &scene)),
        _lot(seed)
    {
        _world.setGravity(bulletVector(0.0, 0.0, -gravity));
        addWalls();
        scene.addUpdateCallback(_hands);
        int number = 0;
        for (const double half_m : {0.018, 0.015, 0.013})
            add(scene, true, half_m, number++);
        for (const double half_m : {0.014, 0.012})
            add(scene, false, half_m, number++);
    }

    ~Toys()
    {
        for (const Toy& toy : _toys)
            _world.removeRigidBody(toy.body.get());
        for (const auto& wall : _walls)
            _world.removeRigidBody(wall.get());
    }

    Toys(const Toys&) = delete;
    Toys& operator=(const Toys&) = delete;

    /// Counts pushes, returns toys that have left the box, and tosses one up if \a tosses.
    void update(bool tosses)
    {
        for (Toy& toy : _toys)
        {
            follow(toy);
            const osg::Vec3d place = toy.last;
            const bool isInside = std::abs(place.x()) < kHalfWidth_m + kWall_m &&
                                  std::abs(place.y()) < kHalfDepth_m + kWall_m &&
                                  std::abs(place.z()) < kHalfHeight_m + kWall_m;
            if (isInside) continue; // false for NaN, too
            ++_returned;
            btTransform middle;
            middle.setIdentity();
            toy.body->setWorldTransform(middle);
            toy.body->setLinearVelocity(bulletVector(0.0, 0.0, 0.0));
            toy.body->setAngularVelocity(bulletVector(0.0, 0.0, 0.0));
        }
        if (!tosses) return;
        std::uniform_int_distribution<std::size_t> which(0, _toys.size() - 1);
        std::uniform_real_distribution<double> aside(-0.15, 0.15);
        btRigidBody& tossed = *_toys[which(_lot)].body;
        tossed.setLinearVelocity(bulletVector(aside(_lot), aside(_lot), 0.45));
        tossed.setAngularVelocity(bulletVector(20.0 * aside(_lot), 20.0 * aside(_lot), 0.0));
        ++_tossed;
    }

    std::vector<Toy>& all() { return _toys; }
    const std::vector<Toy>& all() const { return _toys; }
    Toy* find(const osg::Node* surface)
    {
        for (Toy& toy : _toys)
            if (toy.surface == surface) return &toy;
        return nullptr;
    }

    std::uint64_t tosses() const { return _tossed; }
    std::uint64_t returns() const { return _returned; }
    int handBodies() const { return _hands->getNumBodies(); }

private:
    void addWalls()
    {
        const double half[3] = {kHalfWidth_m, kHalfDepth_m, kHalfHeight_m};
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0})
            {
                double size[3] = {0.4, 0.4, 0.4};
                double place[3] = {0.0, 0.0, 0.0};
                size[axis] = kWall_m;
                place[axis] = side * (half[axis] + kWall_m);
                _wallShapes.push_back(
                    std::make_unique<btBoxShape>(bulletVector(size[0], size[1], size[2])));
                btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, _wallShapes.back().get());
                info.m_startWorldTransform.setOrigin(bulletVector(place[0], place[1], place[2]));
                info.m_restitution = btScalar(1.0);
                _walls.push_back(std::make_unique<btRigidBody>(info));
                _world.addRigidBody(_walls.back().get());
            }
    }

    void add(osgMidair::HapticScene& scene, bool isBall, double half_m, int number)
    {
        Toy toy;
        toy.name = fmt::format("{} {}", isBall ? "ball" : "cube", number + 1);
        const double within = half_m - kWithin_m;
        if (isBall)
            toy.shape = std::make_unique<btSphereShape>(btScalar(within));
        else
            toy.shape = std::make_unique<btBoxShape>(bulletVector(within, within, within));
        btVector3 inertia;
        toy.shape->calculateLocalInertia(btScalar(kMass_kg), inertia);
        btRigidBody::btRigidBodyConstructionInfo info(
            btScalar(kMass_kg), nullptr, toy.shape.get(), inertia);
        info.m_restitution = btScalar(kRestitution);
        info.m_friction = btScalar(0.4);
        info.m_rollingFriction = btScalar(0.0005);
        info.m_startWorldTransform.setOrigin(
            bulletVector(-0.052 + 0.026 * number, 0.02 * ((number % 2) * 2 - 1), 0.02));
        toy.body = std::make_unique<btRigidBody>(info);
        toy.body->setActivationState(DISABLE_DEACTIVATION);
        toy.body->setCcdMotionThreshold(btScalar(0.5 * within));
        toy.body->setCcdSweptSphereRadius(btScalar(0.6 * within));
        _world.addRigidBody(toy.body.get());
        toy.last = placeOf(*toy.body);

        osg::ref_ptr<osg::Shape> shape;
        if (isBall)
            shape = new osg::Sphere(osg::Vec3(), static_cast<float>(half_m));
        else
            shape = new osg::Box(osg::Vec3(), static_cast<float>(2.0 * half_m));
        toy.surface = new osgMidair::HapticSurface;
        toy.surface->setName(toy.name);
        toy.surface->setTouchEvents(true);
        toy.surface->setMaterial(isBall ? "rubber" : "glass");
        toy.surface->addChild(
            solid(shape, kShownColors[static_cast<std::size_t>(number) % kShownColors.size()]));
        osg::ref_ptr<osg::MatrixTransform> carried = new osg::MatrixTransform;
        carried->setDataVariance(osg::Object::DYNAMIC);
        carried->setUpdateCallback(new osgMidair::RigidBodyCallback(_steps, *toy.body));
        carried->addChild(toy.surface);
        scene.addChild(carried);
        _toys.push_back(std::move(toy));
    }

    // A push is a contact with a hand's bone in the newest step.
    void follow(Toy& toy)
    {
        bool isPushed = false;
        for (int i = 0; i < _world.getDispatcher()->getNumManifolds() && !isPushed; ++i)
        {
            const btPersistentManifold& met =
                *_world.getDispatcher()->getManifoldByIndexInternal(i);
            const bool isFirst = met.getBody0() == toy.body.get();
            if (met.getNumContacts() == 0 || (!isFirst && met.getBody1() != toy.body.get()))
                continue;
            int hand = 0;
            int bone = 0;
            isPushed = _hands->getBone(*(isFirst ? met.getBody1() : met.getBody0()), hand, bone);
        }
        const osg::Vec3d place = placeOf(*toy.body);
        if (isPushed) toy.way_m += (place - toy.last).length();
        if (isPushed && !toy.isPushed) ++toy.pushes;
        toy.isPushed = isPushed;
        toy.last = place;
    }

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

/// Five toys with weak gravity, so that hands and fields can follow them.
class Toybox : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"toybox",
                "Balls and cubes that bounce in the array: push them, and feel them.",
                "Push the toys with your hand"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--gravity", _gravity, "Gravity, m/s^2")
            ->check(CLI::Range(0.0, 20.0))
            ->capture_default_str();
        app.add_option("--toss", _toss_s, "Interval between tosses of a toy, s; 0: never")
            ->check(CLI::Range(0.0, 3600.0))
            ->capture_default_str();
    }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::AUTO;
        settings.motionTolerance = 0.02;
        settings.prediction = osgMidair::HapticSettings::KALMAN;
    }

    void build(Stage& stage) override
    {
        stage.lit.addChild(glassBox(
            {}, osg::Vec3d(Toys::kHalfWidth_m, Toys::kHalfDepth_m, Toys::kHalfHeight_m) * 2.0));
        _toys = std::make_unique<Toys>(stage.haptics, _gravity, stage.seed);
    }

    Viewpoint viewpoint() const override
    {
        return {{0.30, -0.50, 0.30}, {0.0, -0.012, 0.0}, osg::Z_AXIS, 19.5};
    }

    // A flat hand that comes from the visitor's side, sweeps the box twice and leaves.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 8.0;
        constexpr double kInside_s = 6.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > kInside_s) return false;
        const double in = std::min({1.0, t / 0.8, (kInside_s - t) / 0.8});
        const osg::Vec3d tip(0.05 * std::sin(2.0 * osg::PI * t / 3.0),
                             -0.14 + 0.16 * in,
                             -0.032 + 0.012 * std::sin(2.0 * osg::PI * t / 1.7));
        hands.push_back(osgMidair::openHand(1, tip, osg::Quat(osg::PI_2, osg::X_AXIS)));
        return true;
    }

    void update(const Moment& now) override
    {
        const bool tosses = _toss_s > 0.0 && now.isSomebodyThere && now.time_s >= _nextToss_s;
        if (tosses) _nextToss_s = now.time_s + _toss_s;
        _toys->update(tosses);
    }

    void touched(const osgMidair::Touch& touch) override
    {
        if (Toy* toy = _toys->find(touch.node)) ++toy->touches;
        stroked(touch);
    }
    void stroked(const osgMidair::Touch& touch) override
    {
        if (Toy* toy = _toys->find(touch.node)) toy->force_N = std::max(toy->force_N, touch.force);
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        figures["tossed"] = _toys->tosses();
        figures["broughtBack"] = _toys->returns();
        for (const Toy& toy : _toys->all())
            figures["toys"].push_back({{"name", toy.name},
                                       {"pushes", toy.pushes},
                                       {"pushedWay_mm", 1e3 * toy.way_m},
                                       {"touches", toy.touches},
                                       {"largestForce_mN", 1e3 * toy.force_N}});
    }

private:
    double _gravity = 1.6;
    double _toss_s = 2.0;
    double _nextToss_s = 1.0;
    std::unique_ptr<Toys> _toys;
};

} // namespace

int main(int argc, char** argv)
{
    Toybox toybox;
    return runInstallation(toybox, argc, argv);
}
