#pragma once

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Geometry>

#include <map>
#include <memory>
#include <utility>
#include <vector>

class btCollisionObject;
class btDiscreteDynamicsWorld;

namespace midair::bridge
{

/// Hands as kinematic bodies of a Bullet world: one capsule per bone, which pushes other bodies and
/// isn't pushed. The world must outlive the bodies; for the thread that steps it.
class HandBodies
{
public:
    explicit HandBodies(btDiscreteDynamicsWorld& world);
    ~HandBodies(); ///< takes the bodies out of the world

    HandBodies(const HandBodies&) = delete;
    HandBodies& operator=(const HandBodies&) = delete;

    /// Moves the bodies to \a hands (metres, the world's frame), adds new ones and removes those
    /// whose bone has been lost for more than kHold_s. \a steps (>= 1): number of calls of the
    /// world's stepSimulation() until the next update; the motion is divided among them, so that
    /// the bodies have the hands' velocity. A time before the last one starts again.
    void update(const HandFrame& hands, int steps = 1);

    int count() const { return static_cast<int>(_bodies.size()); }

    /// Returns the pushes in the world's steps since the last call, or in those before if there was
    /// none: each bone with each movable body, and the place on the body at its present pose. Any
    /// thread.
    std::vector<HandPress> presses();

    /// Returns true if \a object is one of these bodies, with its Hand::id and bone (see
    /// handCapsules()).
    bool find(const btCollisionObject& object, int& hand, int& bone) const;

    static constexpr double kHold_s = 0.1;
    /// A bone that moved farther than this between two updates starts again at the new place
    /// without velocity: no hand moves so fast.
    static constexpr double kJump_m = 0.3;

private:
    struct Body;
    class Pushes;
    using Key = std::pair<int, int>; ///< hand and bone

    void place(const HandCapsule& capsule, double time_s, int steps);

    btDiscreteDynamicsWorld& _world;
    std::unique_ptr<Pushes> _pushes;
    std::map<Key, std::unique_ptr<Body>> _bodies;
    double _time_s = 0.0;
};

} // namespace midair::bridge
