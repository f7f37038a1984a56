#pragma once

#include <Eigen/Geometry>

namespace midair::bridge
{

/// Where a head is at a time.
struct Head
{
    double time_s = 0.0;
    /// From the head to the scene's world, rigid, metres. Its origin is the midpoint between the
    /// eyes; it looks along -z, with +y up and +x to its right, as OSG's eye space and OpenXR's
    /// view space do.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    bool isTracked = false; ///< false: it isn't known where the head is, and the pose says nothing
    double age_s = 0.0;     ///< >= 0; how long before \c time_s it was seen
};

/// The pose at \a place with the turn \a turn, which needs no length of 1.
inline Eigen::Isometry3d headPose(const Eigen::Vector3d& place, const Eigen::Quaterniond& turn)
{
    return Eigen::Translation3d(place) * turn.normalized();
}

} // namespace midair::bridge
