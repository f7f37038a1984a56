#include "engine-bridge/bodies/HandBodies.h"

#include "haptics/base/SmallMatrices.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btMotionState.h>

namespace midair::bridge
{

namespace
{

/// A shape is rebuilt when a bone's length or radius changed by more than this: trackers measure
/// both in each frame.
constexpr double kShapeTolerance_m = 5e-4;

/// Motion state of a kinematic body: each step moves it a share of the way to the newest pose.
/// Bullet derives the body's velocity from the step.
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
    // Bullet calls this once per step, through a const function.
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
        body.setActivationState(DISABLE_DEACTIVATION); // so that it wakes bodies that it touches
        body.setUserIndex(capsule.hand);
        body.setUserIndex2(capsule.bone);
        world.addRigidBody(&body); // in the static group, so that hands don't push each other
    }
    ~Body() { world.removeRigidBody(&body); }
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;

    /// Places it without a velocity.
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

/// Sums the pushes of the hands' bodies at the end of each step of the world: the impulses with
/// which Bullet keeps bodies ahead of them.
class HandBodies::Pushes final : public btActionInterface
{
public:
    Pushes(btDiscreteDynamicsWorld& world, const HandBodies& hands) : _world(world), _hands(hands)
    {
        _world.addAction(this);
    }
    ~Pushes() override { _world.removeAction(this); }
    Pushes(const Pushes&) = delete;
    Pushes& operator=(const Pushes&) = delete;

    void updateAction(btCollisionWorld* world, btScalar step_s) override
    {
        const base::Lock lock(_mutex);
        if (std::exchange(_isRead, false))
        {
            _pushes.clear();
            _time_s = 0.0;
        }
        _time_s += static_cast<double>(step_s);
        btDispatcher& dispatcher = *world->getDispatcher();
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
            add(*dispatcher.getManifoldByIndexInternal(i));
        // The application may have deleted a body pushed in an earlier step.
        const btCollisionObjectArray& all = world->getCollisionObjectArray();
        for (Push& push : _pushes)
            if (all.findLinearSearch(const_cast<btCollisionObject*>(push.body)) < all.size())
                push.place = push.body->getWorldTransform() * push.inBody;
    }
    void debugDraw(btIDebugDraw*) override {}

    std::vector<HandPress> read()
    {
        const base::Lock lock(_mutex);
        _isRead = true;
        std::vector<HandPress> presses;
        for (const Push& push : _pushes)
            presses.push_back({push.bone.first,
                               push.bone.second,
                               Eigen::Vector3d(push.place.x(), push.place.y(), push.place.z()),
                               _time_s > 0.0 ? push.impulse_Ns / _time_s : 0.0});
        return presses;
    }

private:
    /// Push of one bone on one body.
    struct Push
    {
        Key bone;
        const btCollisionObject* body = nullptr; ///< check that it still exists before use
        btVector3 inBody;                        ///< of the newest step, in the body's frame
        btVector3 place;                         ///< m, in the world
        double impulse_Ns = 0.0;
    };

    void add(const btPersistentManifold& contact) MIDAIR_REQUIRES(_mutex)
    {
        const bool isFirst = contact.getBody0()->isKinematicObject();
        const btCollisionObject* hand = isFirst ? contact.getBody0() : contact.getBody1();
        const btCollisionObject* body = isFirst ? contact.getBody1() : contact.getBody0();
        Key bone;
        if (!hand->isKinematicObject() || body->isStaticOrKinematicObject() ||
            !_hands.find(*hand, bone.first, bone.second))
            return;
        double sum_Ns = 0.0;
        btVector3 place(0, 0, 0);
        for (int i = 0; i < contact.getNumContacts(); ++i)
        {
            const btManifoldPoint& point = contact.getContactPoint(i);
            if (!(point.m_appliedImpulse > 0)) continue;
            sum_Ns += static_cast<double>(point.m_appliedImpulse);
            place += point.m_appliedImpulse * (isFirst ? point.m_localPointB : point.m_localPointA);
        }
        if (!(sum_Ns > 0.0)) return;
        auto push =
            std::find_if(_pushes.begin(),
                         _pushes.end(),
                         [&](const Push& one) { return one.bone == bone && one.body == body; });
        if (push == _pushes.end())
        {
            push = _pushes.insert(push, Push());
            push->bone = bone;
            push->body = body;
        }
        push->inBody = place / static_cast<btScalar>(sum_Ns);
        push->impulse_Ns += sum_Ns;
    }

    btDiscreteDynamicsWorld& _world;
    const HandBodies& _hands;
    base::Mutex _mutex;
    bool _isRead MIDAIR_GUARDED_BY(_mutex) = false;
    double _time_s MIDAIR_GUARDED_BY(_mutex) = 0.0; ///< of the steps that are summed
    std::vector<Push> _pushes MIDAIR_GUARDED_BY(_mutex);
};

HandBodies::HandBodies(btDiscreteDynamicsWorld& world) :
    _world(world),
    _pushes(std::make_unique<Pushes>(world, *this))
{
}

HandBodies::~HandBodies() = default;

std::vector<HandPress> HandBodies::presses()
{
    return _pushes->read();
}

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
            body.reset(); // removes the old one first
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
