#pragma once

#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "engine-bridge/scene/MeshCache.h"
#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "plugin/scene/TaggedObstacles.h"

#include <osg/observer_ptr>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace osgMidair
{

/// What is active under a root, as haptic objects and obstacles in array coordinates; what did not
/// change since the frame before is only looked at, not made again.
///
/// Belongs to the thread that updates the scene.
class SceneCollector
{
public:
    /// \a owner: the HapticScene that it collects for; null: something else, which all scenes that
    /// it meets are inside of. \a say is told what can't be felt, with the node's path, possibly
    /// again and again.
    SceneCollector(const osg::Node* owner, std::function<void(const std::string&)> say);

    /// Where nothing under the root is haptic, the whole of it is felt so.
    void setDefaultProperty(const HapticProperty& property) { _default = property; }

    /// World in scene units -> array, affine; obstacles count where \a shadows is on.
    void configure(const Eigen::Matrix4d& toArray, bool shadows);

    /// Tags are looked for with the next collect(), not only every kTagFrames frames.
    void dirtyTags() { _tagFrame = 0; }
    static constexpr unsigned int kTagFrames = 60;

    /// One frame: what is to be felt under \a root, whose parent is at \a world, in \a objects.
    /// Those are to be as the last collect() left them, else forget() comes first. False when they
    /// are also for this frame.
    bool collect(osg::Node& root,
                 const osg::Matrixd& world,
                 std::vector<midair::bridge::HapticObject>& objects);

    /// The next collect() makes all objects anew.
    void forget() { _kept = false; }

    /// The obstacles of this frame, after those of \a props.
    void addObstacles(std::vector<midair::bridge::Capsule>& props) const
    {
        _obstacles.addTo(props);
    }

    int instances() const { return _felt; } ///< that can be felt
    std::uint64_t extractions() const { return _meshes.extractions(); }

    /// Haptic scenes that the last collect() found active inside the owner's.
    const std::vector<const HapticScene*>& innerScenes() const { return _visitor.innerScenes(); }

    /// The node of an instance; null when it is gone.
    osg::Node* nodeOf(std::uint64_t instance) const;

private:
    /// What is remembered of an instance from frame to frame.
    struct Known
    {
        osg::observer_ptr<osg::Node> node;
        std::string path;
        std::string tag;
        HapticProperty raw;      ///< as the node has it
        HapticProperty property; ///< with what was out of range repaired
        unsigned int seen = 0;   ///< frame
        std::uint64_t shape = 0; ///< as the mesh cache counts
        osg::Matrixd world;
        std::size_t first = 0; ///< of its objects
        std::size_t count = 0; ///< of them; none when it can't be felt
    };

    Known& know(const HapticInstance& instance, bool& fresh, bool& changed);
    void fill(const HapticInstance& instance);
    void fillParts(const HapticInstance& instance, Known& known);
    void fillObstacle(const HapticInstance& instance);
    void forgetUnseen();
    void sayWarnings(const std::string& path);

    const std::function<void(const std::string&)> _say;
    std::optional<HapticProperty> _default;
    Eigen::Matrix4d _toArray = Eigen::Matrix4d::Identity();
    bool _shadows = false;
    CollectHapticSurfacesVisitor _visitor;
    midair::bridge::MeshCache _meshes;
    midair::bridge::ExtractOptions _extract;
    TaggedObstacles _obstacles;
    std::unordered_map<std::uint64_t, Known> _known;
    std::vector<std::string> _warnings;
    std::vector<midair::bridge::CachedMesh> _parts; ///< of the instance being filled in
    std::vector<midair::bridge::HapticObject>* _objects = nullptr; ///< during collect()
    std::size_t _count = 0;                                        ///< of them so far
    int _felt = 0;
    unsigned int _frame = 0;
    unsigned int _tagFrame = 0; ///< frames until tags are looked for
    bool _kept = false;         ///< the objects are those of the frame before
    bool _changed = false;
};

} // namespace osgMidair
