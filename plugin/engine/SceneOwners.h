#pragma once

#include <osg/ref_ptr>

#include <cstddef>
#include <string>
#include <vector>

namespace osg
{
class Node;
}

namespace osgViewer
{
class ViewerBase;
}

namespace osgMidair
{

class HapticEngine;

/// Kinds of owners that can play the scene below a node. At the same node a later kind takes
/// precedence.
enum class OwnerKind
{
    SCENE,
    CALLBACK,
    DEVICE
};

/// Registers an owner of the scene below \a root for its lifetime. From any thread.
class SceneOwner
{
public:
    SceneOwner(const osg::Node& root, OwnerKind kind, HapticEngine& engine);
    ~SceneOwner();
    SceneOwner(const SceneOwner&) = delete;
    SceneOwner& operator=(const SceneOwner&) = delete;

    /// Returns the name, for messages, of an outer owner, which plays the scene instead of this
    /// one; empty: there is none.
    std::string outer() const;

    /// False: it has no leader, so it owns nothing until it gets one.
    void setLed(bool isLed);

private:
    const osg::Node& _root; ///< dereferenced only in outer(), which needs it alive
    const OwnerKind _kind;
};

/// Returns the engine of the device or callback that owns the scene below \a node; of both, the
/// device's. Null if none has a leader, or if it is being deleted. Doesn't find a HapticScene's.
/// From any thread.
osg::ref_ptr<HapticEngine> engineOwning(const osg::Node& node);

/// One of the process's places for playing scenes. They are limited because a file may have any
/// number of scenes, and each that plays takes threads and memory. From any thread.
class PlayingPlace
{
public:
    /// Maximum of scenes that a process plays.
    static constexpr std::size_t kMost = 16;

    PlayingPlace() = default;
    ~PlayingPlace() { leave(); }
    PlayingPlace(const PlayingPlace&) = delete;
    PlayingPlace& operator=(const PlayingPlace&) = delete;

    /// Returns true if it has a place from now on; otherwise it waits for one until leave().
    bool take();
    void leave();
    /// Returns true if others wait and none is free: scenes that aren't shown should leave.
    static bool isWanted();
};

/// An engine's membership in a group played as one: joined scenes that a viewer shows side by side
/// with the same array. The first member plays for the others.
class JoinedScene
{
public:
    /// Joins nothing before setJoined(true).
    explicit JoinedScene(HapticEngine& engine);
    ~JoinedScene();
    JoinedScene(const JoinedScene&) = delete;
    JoinedScene& operator=(const JoinedScene&) = delete;

    /// From any thread.
    void setJoined(bool joined);
    bool isJoined() const;
    /// Sets the viewer that shows the scene; the last call counts.
    void follow(const osgViewer::ViewerBase& viewer);

    /// Returns the engine that plays this one's scene; null: itself. On the update thread.
    osg::ref_ptr<HapticEngine> host() const;
    /// Stores the engines whose host this one is in \a guests. On the update thread.
    void findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const;

private:
    HapticEngine& _engine;
};

} // namespace osgMidair
