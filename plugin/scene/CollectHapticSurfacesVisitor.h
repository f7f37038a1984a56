#pragma once

#include <osgMidair/HapticProperty>

#include <osg/ClipNode>
#include <osg/Matrixd>
#include <osg/NodeVisitor>
#include <osg/Vec4d>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace osgMidair
{

class HapticPoints;
class HapticScene;

/// One haptic node, obstacle or reflector, on one node path.
struct HapticInstance
{
    enum Kind
    {
        FELT,
        OBSTACLE, ///< a real object that blocks sound; not haptic
        REFLECTOR ///< a real object whose flat faces reflect sound; not haptic
    };

    osg::Node* node = nullptr;
    std::uint64_t id = 0; ///< hash of the node path
    osg::Matrixd world;   ///< from the frame of the node's children to the world, in scene units
    /// property of a HapticSurface or HapticPoints; null: the node has a tag
    const HapticProperty* property = nullptr;
    const HapticPoints* points = nullptr; ///< the node, if it is one
    /// false below a camera or an absolute frame, where nodes have no position in the world
    bool inWorld = true;
    Kind kind = FELT;
    /// below a node that turns with the camera; world excludes that rotation
    bool followsCamera = false;
    /// planes of ClipNodes above it, in the world; anything behind one is invisible
    std::vector<osg::Vec4d> clips;

    bool isFelt() const { return kind == FELT; }
};

/// A root of a haptic scene, and the transform from its parent's frame to the world.
struct SceneRoot
{
    osg::Node* node = nullptr;
    osg::Matrixd world;
};

/// Finds every HapticSurface, every HapticPoints and every node tagged "haptic", "obstacle" or
/// "reflector" among the active children, once per node path. It respects Switch, node masks and
/// LOD (at its finest level) and does not depend on any camera. Run it after the update traversal.
///
/// It skips subtrees without haptic nodes: haptic nodes request the event traversal, and OSG counts
/// such nodes up to the root. For tagged nodes markTags() has to make that request.
class CollectHapticSurfacesVisitor : public osg::NodeVisitor
{
public:
    /// \a owner: the scene that it collects for. Other scenes that it meets are inner ones: their
    /// surfaces belong to the owner, unless they are disabled. Null: the owner is no scene, and all
    /// scenes are inner ones.
    explicit CollectHapticSurfacesVisitor(const osg::Node* owner = nullptr);

    /// Collects the scenes below all \a roots anew. If nothing haptic is found and \a otherwise is
    /// not null, the first root becomes an instance with that property; this is for roots without
    /// any tag, including hidden ones. Reuses memory from call to call.
    void collect(const std::vector<SceneRoot>& roots, const HapticProperty* otherwise = nullptr);

    const std::vector<HapticInstance>& instances() const { return _instances; }

    /// Returns the enabled inner scenes of the last collect().
    const std::vector<const HapticScene*>& innerScenes() const { return _innerScenes; }

    /// Calls \a look with each node on the path to an instance of the last collect(), including its
    /// own.
    void lookAlong(const HapticInstance& instance,
                   const std::function<void(const osg::Node&)>& look) const;

    /// Returns the node path of an instance of the last collect(): "HapticScene/MatrixTransform
    /// 'arm'/HapticSurface 'hand'".
    std::string path(const HapticInstance& instance);

    void apply(osg::Node& node) override;
    void apply(osg::Transform& node) override;
    void apply(osg::Camera& node) override;
    void apply(osg::ClipNode& node) override;
    void apply(osg::Drawable& drawable) override;

private:
    static bool leadsSomewhere(const osg::Node& node)
    {
        return node.getNumChildrenRequiringEventTraversal() > 0;
    }
    void check(osg::Node& node);
    HapticInstance& add(osg::Node& node, const HapticProperty* property);
    std::uint64_t pathId() const;

    /// An enabled plane of a ClipNode on the path.
    struct Clip
    {
        osg::Vec4d plane;     ///< in the world
        GLenum mode = 0;      ///< the mode that enables it
        std::size_t from = 0; ///< index of the ClipNode in the node path
    };
    void addClips(HapticInstance& instance) const;

    /// Returns false for a disabled inner scene: nothing below it is played.
    bool enter(const osg::Node& node);

    const osg::Node* const _owner;
    std::vector<const HapticScene*> _innerScenes;
    std::vector<HapticInstance> _instances;
    std::vector<osg::Node*> _paths; ///< concatenated node paths, each ended by null
    std::vector<std::size_t> _pathStarts;
    std::vector<Clip> _clips;
    osg::Matrixd _world;
    bool _inWorld = true;
    bool _followsCamera = false;
};

/// Makes tagged nodes below \a root request the event traversal, as haptic nodes do. Traverses the
/// whole subtree: not for every frame.
void markTags(osg::Node& root);

/// Reads the text of a tag: user value "haptic" (a bool or a text), or a description "haptic ...".
/// Returns false if the node has none.
bool hapticTag(const osg::Node& node, std::string& text);
bool hasHapticTag(const osg::Node& node);

/// Returns true if the node has the user value "obstacle" (a bool) or a description "obstacle": a
/// real object that blocks sound.
bool hasObstacleTag(const osg::Node& node);

/// Reads the text of the user value "reflector", or of a description "reflector ..", as
/// hapticTag() does.
bool reflectorTag(const osg::Node& node, std::string& text);
bool hasReflectorTag(const osg::Node& node);

/// Returns true for a HapticSurface, a HapticPoints or a node with a marked tag: a separate object.
bool isOwnObject(const osg::Node& node);

} // namespace osgMidair
