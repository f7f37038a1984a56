#pragma once

#include <osgMidair/HapticProperty>

#include <osg/Matrixd>
#include <osg/NodeVisitor>

#include <cstdint>
#include <string>
#include <vector>

namespace osgMidair
{

class HapticScene;

/// One haptic node, or one obstacle, on one node path.
struct HapticInstance
{
    osg::Node* node = nullptr;
    std::uint64_t id = 0; ///< of the node path
    osg::Matrixd world;   ///< the frame of the node's children -> world, in scene units
    const HapticProperty* property = nullptr; ///< of a HapticSurface; null: the node carries a tag
    bool inWorld =
        true; ///< false under a camera or an absolute frame: what hangs there has no place
    bool obstacle = false;      ///< a real thing, in the sound's way: not felt itself
    bool followsCamera = false; ///< below what turns with the camera; world leaves that out
};

/// Finds every HapticSurface and every node tagged "haptic" or "obstacle" among the active
/// children, once per node path: Switch, masks and LOD (at its finest) are honoured, no camera
/// plays a part. Run it after the update traversal.
///
/// Goes only where there is something to find: haptic nodes ask for the event traversal, and OSG
/// counts those that do up to the root, so a subtree without any is passed by. Tagged nodes have to
/// be marked with markTags() for that.
class CollectHapticSurfacesVisitor : public osg::NodeVisitor
{
public:
    /// \a owner: the scene that it collects for. Others that are met are inside it: their surfaces
    /// are its own, unless they are disabled. Null: it is no scene, and all that it meets are
    /// inside.
    explicit CollectHapticSurfacesVisitor(const osg::Node* owner = nullptr);

    /// Starts anew under \a root, whose parent is at \a world. Memory is kept from call to call.
    /// Where nothing haptic is found \a root itself becomes an instance with the property \a
    /// otherwise, if that isn't null.
    void
    collect(osg::Node& root, const osg::Matrixd& world, const HapticProperty* otherwise = nullptr);

    const std::vector<HapticInstance>& instances() const { return _instances; }

    /// The enabled scenes inside the owner's that the last collect() met.
    const std::vector<const HapticScene*>& innerScenes() const { return _innerScenes; }

    /// "HapticScene/MatrixTransform 'arm'/HapticSurface 'hand'" for an instance of the last
    /// collect().
    std::string path(const HapticInstance& instance);

    void apply(osg::Node& node) override;
    void apply(osg::Transform& node) override;
    void apply(osg::Camera& node) override;
    void apply(osg::Drawable& drawable) override;

private:
    static bool leadsSomewhere(const osg::Node& node)
    {
        return node.getNumChildrenRequiringEventTraversal() > 0;
    }
    void check(osg::Node& node);
    HapticInstance& add(osg::Node& node, const HapticProperty* property);
    std::uint64_t pathId() const;

    /// False for a scene inside the owner's that is disabled: nothing under it is felt.
    bool enter(const osg::Node& node);

    const osg::Node* const _owner;
    std::vector<const HapticScene*> _innerScenes;
    std::vector<HapticInstance> _instances;
    std::vector<osg::Node*> _paths; ///< node paths one after the other, each ended by null
    std::vector<std::size_t> _pathStarts;
    osg::Matrixd _world;
    bool _inWorld = true;
    bool _followsCamera = false;
};

/// Has tagged nodes anywhere under \a root counted like haptic ones. Walks the whole subtree: not
/// for every frame.
void markTags(osg::Node& root);

/// The text of a tag: user value "haptic" (a bool or a text), or a description "haptic ...". False
/// without one.
bool hapticTag(const osg::Node& node, std::string& text);
bool hasHapticTag(const osg::Node& node);

/// User value "obstacle" (a bool), or a description "obstacle": a real thing that is in the sound's
/// way.
bool hasObstacleTag(const osg::Node& node);

/// A HapticSurface or a node whose tag was marked: something that is an object of its own.
bool isOwnObject(const osg::Node& node);

} // namespace osgMidair
