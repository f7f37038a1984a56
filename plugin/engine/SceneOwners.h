#pragma once

#include <osg/ref_ptr>

#include <string>

namespace osg
{
class Node;
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

private:
    const osg::Node& _root; ///< dereferenced only in outer(), which needs it alive
    const OwnerKind _kind;
};

/// Returns the engine of the device or callback that owns the scene below \a node, of both the
/// device's; null if there is none, or one that is being deleted. A HapticScene's isn't found here.
/// From any thread.
osg::ref_ptr<HapticEngine> engineOwning(const osg::Node& node);

} // namespace osgMidair
