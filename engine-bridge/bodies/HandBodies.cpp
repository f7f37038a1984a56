#include "engine-bridge/bodies/HandBodies.h"

#include "haptics/base/SmallMatrices.h"

#include <algorithm>
#include <cmath>

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btMotionState.h>

namespace midair::bridge
{

namespace
{

/// A shape is made anew once a bone's length or radius has changed by more than this: trackers
/// measure both in each frame.
constexpr double kShapeTolerance_m = 5e-4;

/// Where Bullet asks a kinematic body to be: each step a share of the way to the newest pose.
/// Bullet takes the body's velocity from the way of a step.
class WayToGo : public btMotionState
{
public:
    void begin(const btTransform& pose) { _from = _to = _now = pose; }
    void go(const btTransform& pose, int steps)
    {
        _from = _now;
        _to = pose;
        _steps = std::max(steps, 1);
        _taken = 0;
    }

    const btTransform& target() const { return _to; }

    void getWorldTransform(btTransform& pose) const override
    {
        _taken = std::min(_taken + 1, _steps);
        const btScalar share = static_cast<btScalar>(_taken) / static_cast<btScalar>(_steps);
        _now.setOrigin(_from.getOrigin().lerp(_to.getOrigin(), share));
        _now.setRotation(_from.getRotation().slerp(_to.getRotation(), share));
        pose = _now;
    }
    void setWorldTransform(const btTransform&) override {} // only dynamic bodies are moved

private:
    btTransform _from = btTransform::getIdentity();
    btTransform _to = btTransform::getIdentity();
    int _steps = 1;
    // Bullet asks once a step, by a const function.
    mutable int _taken = 0;
    mutable btTransform _now = btTransform::getIdentity();
};

/// The pose of Bullet's capsule, which lies along y around its middle.
btTransform poseOf(const Capsule& capsule)
{
    const Eigen::Vector3d middle = 0.5 * (capsule.a + capsule.b);
    const Eigen::Vector3d along = capsule.b - capsule.a;
    const Eigen::Quaterniond turn = along.norm() > 0.0
                                        ? base::turnBetween(Eigen::Vector3d::UnitY(), along)
                                        : Eigen::Quaterniond::Identity();
    return btTransform(btQuaternion(static_cast<btScalar>(turn.x()),
                                    static_cast<btScalar>(turn.y()),
                                    static_cast<btScalar>(turn.z()),
                                    static_cast<btScalar>(turn.w())),
                       btVector3(static_cast<btScalar>(middle.x()),
                                 static_cast<btScalar>(middle.y()),
                                 static_cast<btScalar>(middle.z())));
}

} // namespace

/// One bone in the world.
struct HandBodies::Body
{
    Body(btDiscreteDynamicsWorld& itsWorld, const HandCapsule& capsule) :
        world(itsWorld),
        length_m((capsule.shape.b - capsule.shape.a).norm()),
        radius_m(capsule.shape.radius_m),
        shape(static_cast<btScalar>(radius_m), static_cast<btScalar>(length_m)),
        body(btRigidBody::btRigidBodyConstructionInfo(0, &way, &shape))
    {
        start(poseOf(capsule.shape));
        body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        body.setActivationState(DISABLE_DEACTIVATION); // so that it wakes what it touches
        body.setUserIndex(capsule.hand);
        body.setUserIndex2(capsule.bone);
        world.addRigidBody(&body); // among static bodies, so that hands don't push each other
    }
    ~Body() { world.removeRigidBody(&body); }
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;

    /// Puts it there without a velocity.
    void start(const btTransform& pose)
    {
        way.begin(pose);
        body.setWorldTransform(pose);
        body.setInterpolationWorldTransform(pose);
    }

    bool fits(const Capsule& capsule) const
    {
        return std::abs((capsule.b - capsule.a).norm() - length_m) < kShapeTolerance_m &&
               std::abs(capsule.radius_m - radius_m) < kShapeTolerance_m;
    }

    btDiscreteDynamicsWorld& world;
    double length_m;
    double radius_m;
    btCapsuleShape shape;
    WayToGo way;
    btRigidBody body;
    double seen_s = 0.0;
};

HandBodies::HandBodies(btDiscreteDynamicsWorld& world) : _world(world) {}

HandBodies::~HandBodies() = default;

void HandBodies::place(const HandCapsule& capsule, double time_s, int steps)
{
    std::unique_ptr<Body>& body = _bodies[{capsule.hand, capsule.bone}];
    const btTransform pose = poseOf(capsule.shape);
    if (body)
    {
        const btScalar moved = (pose.getOrigin() - body->way.target().getOrigin()).length();
        const bool jumped = !(moved <= static_cast<btScalar>(kJump_m));
        if (jumped || !body->fits(capsule.shape))
        {
            const btTransform before = body->way.target();
            body.reset(); // first the old one out
            body = std::make_unique<Body>(_world, capsule);
            if (!jumped) body->start(before);
        }
    }
    else
        body = std::make_unique<Body>(_world, capsule);
    body->way.go(pose, steps);
    body->seen_s = time_s;
}

void HandBodies::update(const HandFrame& hands, int steps)
{
    if (!std::isfinite(hands.time_s)) return;
    if (hands.time_s < _time_s) _bodies.clear();
    _time_s = hands.time_s;
    for (const HandCapsule& capsule : handCapsules(hands))
        place(capsule, _time_s, steps);
    for (auto body = _bodies.begin(); body != _bodies.end();)
        body = _time_s - body->second->seen_s > kHold_s ? _bodies.erase(body) : std::next(body);
}

bool HandBodies::find(const btCollisionObject& object, int& hand, int& bone) const
{
    const auto found = _bodies.find({object.getUserIndex(), object.getUserIndex2()});
    if (found == _bodies.end() || &found->second->body != &object) return false;
    hand = found->first.first;
    bone = found->first.second;
    return true;
}

} // namespace midair::bridge
