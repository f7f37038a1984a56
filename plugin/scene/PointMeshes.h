#pragma once

#include "engine-bridge/scene/MeshCache.h"
#include "haptics/base/text/MessageLog.h"

#include <osgMidair/HapticPoints>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace osgMidair
{

/// The points of a HapticPoints as a mesh, and the pressure of the strongest.
struct PointMesh
{
    midair::bridge::CachedMesh mesh;
    /// in the property's unit; the mesh's intensities are shares of it. 0: the property's own
    double pressure = 0.0;
    std::vector<std::string> leftOut; ///< what is told of points that are left out
};

/// Makes meshes of HapticPoints and keeps them while they stay the same.
class PointMeshes
{
public:
    /// Gets the code of a message and its text, without the node's path.
    using Say = std::function<void(midair::base::MessageCode, const std::string&)>;

    /// Returns the points of \a node, which \a toArray takes to the array's frame; null, after \a
    /// say was told why, if none can be felt. The result stays valid until the next call. \a say is
    /// told in each call what is left out (POINTS_INVALID): the caller knows what it has said.
    const PointMesh* get(const HapticPoints& node, const Eigen::Matrix4d& toArray, const Say& say);

    void endFrame();

private:
    /// Points with one scale and shear applied.
    struct Entry
    {
        unsigned int points = 0; ///< HapticPoints::getModifiedCount()
        Eigen::Matrix3d stretch;
        PointMesh made;
        std::uint64_t used = 0; ///< frame of the last use
    };

    std::vector<Entry> _entries;
    std::uint64_t _frame = 0;
    std::uint64_t _nextId = std::uint64_t(1) << 63; ///< apart from those of a MeshCache
};

} // namespace osgMidair
