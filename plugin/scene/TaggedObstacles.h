#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/scene/MeshCache.h"

#include <osg/Node>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

namespace osgMidair
{

/// Turns nodes tagged "obstacle" into the capsules for computing shadows. For the update thread; a
/// frame without changed shapes allocates nothing.
class TaggedObstacles
{
public:
    void beginFrame();

    /// Adds the obstacle \a node. \a toArray: transform from the frame of its children to the
    /// array. Leaves out subtrees for which \a skip returns true.
    void add(osg::Node& node,
             const Eigen::Matrix4d& toArray,
             const std::function<bool(const osg::Node&)>& skip,
             std::vector<std::string>& warnings);

    void endFrame();

    /// Appends the capsules of this frame to \a props, in the array frame.
    void addTo(std::vector<midair::bridge::Capsule>& props) const;

private:
    struct Fit
    {
        std::vector<midair::bridge::Capsule> capsules; ///< mesh frame
        int unusedFrames = 0;
    };

    /// Logs once why \a node blocks no sound, while that is so.
    void tellIdle(osg::Node& node, bool hasPlace, std::vector<std::string>& warnings);

    std::set<const osg::Node*> _idle; ///< without a mesh in this frame; only compared
    std::set<const osg::Node*> _idleBefore;
    midair::bridge::MeshCache _meshes{false}; ///< an unknown obstacle blocks no sound
    midair::bridge::ExtractOptions _extract;
    std::vector<midair::bridge::CachedMesh> _parts;
    std::unordered_map<std::uint64_t, Fit> _fits; ///< by mesh
    std::vector<midair::bridge::Capsule> _props;
};

} // namespace osgMidair
