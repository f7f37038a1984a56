#pragma once

#include <string>

namespace osg
{
class Node;
}

namespace osgMidair
{

/// Who plays what is under a node, a HapticScene by default. At the same node the later one comes
/// first.
enum class OwnerKind
{
    SCENE,
    CALLBACK,
    DEVICE
};

/// As long as it lives, what is under \a root has that owner. From any thread.
class SceneOwner
{
public:
    SceneOwner(const osg::Node& root, OwnerKind kind);
    ~SceneOwner();
    SceneOwner(const SceneOwner&) = delete;
    SceneOwner& operator=(const SceneOwner&) = delete;

    /// Who plays what is under the root in this one's place, being further out; for messages.
    /// Empty: nobody.
    std::string outer() const;

private:
    const osg::Node& _root; ///< looked at in outer() alone, while it is there
    const OwnerKind _kind;
};

} // namespace osgMidair
