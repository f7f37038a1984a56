#pragma once

#include <Eigen/Geometry>

namespace midair::bridge
{

/// Pose of a head at a time.
struct Head
{
    double time_s = 0.0;
    /// From the head to the scene's world, rigid, metres. Its origin is the midpoint between the
    /// eyes; it looks along -z, with +y up and +x to its right, as OSG's eye space and OpenXR's
    /// view space do.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    bool isTracked = false; ///< false: the position is unknown, and the pose is meaningless
    double age_s = 0.0;     ///< >= 0; time before \c time_s at which it was seen
};

/// Returns the pose at \a place with the orientation \a turn, which need not be normalized.
inline Eigen::Isometry3d headPose(const Eigen::Vector3d& place, const Eigen::Quaterniond& turn)
{
    return Eigen::Translation3d(place) * turn.normalized();
}

} // namespace midair::bridge
