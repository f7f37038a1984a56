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

/// Hands as kinematic bodies of a Bullet world: a capsule for each bone, which pushes what it meets
/// and isn't pushed. The world must outlive the bodies; for the thread that steps it.
class HandBodies
{
public:
    explicit HandBodies(btDiscreteDynamicsWorld& world);
    ~HandBodies(); ///< takes the bodies out of the world

    HandBodies(const HandBodies&) = delete;
    HandBodies& operator=(const HandBodies&) = delete;

    /// Moves the bodies to \a hands (metres, the world's frame), adds those that are new and takes
    /// out those whose bone has been lost for more than kHold_s. \a steps (>= 1): number of times
    /// that the world's stepSimulation() will be called until the next update; the way is divided
    /// among them, so that the bodies have the hands' velocity. A time before the last one begins
    /// anew.
    void update(const HandFrame& hands, int steps = 1);

    int count() const { return static_cast<int>(_bodies.size()); }

    /// What the hands have pushed in the world's steps since the last call, or in those before if
    /// there was none: each bone with each body that may move, and the place on it, where the body
    /// is now. Any thread.
    std::vector<HandPress> presses();

    /// Returns true for one of these bodies, with its Hand::id and its bone (see handCapsules()).
    bool find(const btCollisionObject& object, int& hand, int& bone) const;

    static constexpr double kHold_s = 0.1;
    /// Bones that moved farther than this between two updates were not moved by a hand: they start
    /// anew there, without velocity.
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
