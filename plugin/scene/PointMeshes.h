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
    /// in the property's unit; the mesh's intensities are fractions of it. 0: the property's own
    double pressure = 0.0;
    std::vector<std::string> leftOut; ///< messages about points left out
};

/// Makes meshes of HapticPoints and keeps them while they don't change.
class PointMeshes
{
public:
    /// Receives a message's code and its text, without the node's path.
    using Say = std::function<void(midair::base::MessageCode, const std::string&)>;

    /// Returns the points of \a node in the array's frame, by \a toArray; null, after a call of \a
    /// say with the reason, if none is usable. The result is valid until the next call. Each call
    /// also reports the points left out (POINTS_INVALID); the caller removes repetitions.
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
    std::uint64_t _nextId = std::uint64_t(1) << 63; ///< distinct from those of a MeshCache
};

} // namespace osgMidair
