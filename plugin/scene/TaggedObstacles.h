#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/scene/MeshCache.h"

#include <osg/Node>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

namespace osgMidair
{

/// Nodes tagged "obstacle" as the capsules that shadows are reckoned with. On the update thread; a
/// frame in which none changed its shape allocates nothing.
class TaggedObstacles
{
public:
    bool saidIdle = false; ///< it has been told that there are some while shadows are off

    void beginFrame();

    /// \a toArray: coordinates of \a node's children -> array. Subtrees that \a skip names are left
    /// out.
    void add(osg::Node& node,
             const Eigen::Matrix4d& toArray,
             const std::function<bool(const osg::Node&)>& skip,
             std::vector<std::string>& warnings);

    void endFrame();

    /// This frame's, in the array frame.
    void addTo(std::vector<midair::bridge::Capsule>& props) const;

private:
    struct Fit
    {
        std::vector<midair::bridge::Capsule> capsules; ///< mesh frame
        int unusedFrames = 0;
    };

    midair::bridge::MeshCache _meshes;
    midair::bridge::ExtractOptions _extract;
    std::vector<midair::bridge::CachedMesh> _parts;
    std::unordered_map<std::uint64_t, Fit> _fits; ///< by mesh
    std::vector<midair::bridge::Capsule> _props;
};

} // namespace osgMidair
