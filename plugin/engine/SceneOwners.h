#pragma once

#include <string>

namespace osg
{
class Node;
}

namespace osgMidair
{

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
    SceneOwner(const osg::Node& root, OwnerKind kind);
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

} // namespace osgMidair
