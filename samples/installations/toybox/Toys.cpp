#include "samples/installations/toybox/Toys.h"

#include "samples/installations/shell/Looks.h"

#include <algorithm>
#include <cmath>

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// How far a body's shape is within its surface: a finger that pushes is as deep in what is felt,
/// so that it feels the push.
constexpr double kWithin_m = 0.002;
constexpr double kMass_kg = 0.02;
constexpr double kRestitution = 0.8;
constexpr double kWall_m = 0.05; ///< half its thickness

btVector3 bulletVector(double x, double y, double z)
{
    return {btScalar(x), btScalar(y), btScalar(z)};
}

osg::Vec3d placeOf(const btRigidBody& body)
{
    const btVector3& p = body.getWorldTransform().getOrigin();
    return {p.x(), p.y(), p.z()};
}

} // namespace

Toys::Toys(osgMidair::HapticScene& scene, double gravity, std::uint32_t seed) :
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

Toys::~Toys()
{
    for (const Toy& toy : _toys)
        _world.removeRigidBody(toy.body.get());
    for (const auto& wall : _walls)
        _world.removeRigidBody(wall.get());
}

void Toys::addWalls()
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

void Toys::add(osgMidair::HapticScene& scene, bool isBall, double half_m, int number)
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

Toy* Toys::find(const osg::Node* surface)
{
    for (Toy& toy : _toys)
        if (toy.surface == surface) return &toy;
    return nullptr;
}

// A push is a contact with a bone of a hand in the newest step.
void Toys::follow(Toy& toy)
{
    bool isPushed = false;
    for (int i = 0; i < _world.getDispatcher()->getNumManifolds() && !isPushed; ++i)
    {
        const btPersistentManifold& met = *_world.getDispatcher()->getManifoldByIndexInternal(i);
        const bool isFirst = met.getBody0() == toy.body.get();
        if (met.getNumContacts() == 0 || (!isFirst && met.getBody1() != toy.body.get())) continue;
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

void Toys::update(bool tosses)
{
    for (Toy& toy : _toys)
    {
        follow(toy);
        const osg::Vec3d place = toy.last;
        const bool isInside = std::abs(place.x()) < kHalfWidth_m + kWall_m &&
                              std::abs(place.y()) < kHalfDepth_m + kWall_m &&
                              std::abs(place.z()) < kHalfHeight_m + kWall_m;
        if (isInside) continue; // also false for places that are no numbers
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

} // namespace midair::samples
