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

    /// Returns the name, for messages, of an owner further out, which plays the scene instead of
    /// this one; empty: there is none.
    std::string outer() const;

    /// False: nobody leads it any more, so it owns nothing until somebody does.
    void setLed(bool isLed);

private:
    const osg::Node& _root; ///< dereferenced only in outer(), which needs it alive
    const OwnerKind _kind;
};

/// Returns the engine of the device or callback that owns the scene below \a node, of both the
/// device's; null if there is none that is led, or one that is being deleted. A HapticScene's isn't
/// found here. From any thread.
osg::ref_ptr<HapticEngine> engineOwning(const osg::Node& node);

/// One of the places of scenes that play. A file may have any number of scenes, and each that plays
/// takes threads and memory. From any thread.
class PlayingPlace
{
public:
    /// So many scenes of a process play at most.
    static constexpr std::size_t kMost = 16;

    PlayingPlace() = default;
    ~PlayingPlace() { leave(); }
    PlayingPlace(const PlayingPlace&) = delete;
    PlayingPlace& operator=(const PlayingPlace&) = delete;

    /// Returns true if it has one from now on; else it waits for one until leave().
    bool take();
    void leave();
    /// Returns true if others wait and none is free: who isn't shown should leave.
    static bool isWanted();
};

/// An engine's place among those that are played as one: joined scenes that a viewer shows beside
/// each other and that ask for the same array. The one that is first here plays for the others.
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
    /// Notes the viewer that shows the scene; the last one counts.
    void follow(const osgViewer::ViewerBase& viewer);

    /// Returns the engine that plays this one's scene; null: itself. On the update thread.
    osg::ref_ptr<HapticEngine> host() const;
    /// Puts the engines whose host this one is into \a guests. On the update thread.
    void findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const;

private:
    HapticEngine& _engine;
};

} // namespace osgMidair
