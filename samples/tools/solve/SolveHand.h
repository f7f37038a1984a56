#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/scattering/RoundBody.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace midair::samples
{

/// Returns the direction from which a hand comes to \a array, unit length: that in which the array
/// faces as a whole, or y, if it surrounds the workspace.
Eigen::Vector3d openSideOf(const haptics::TransducerArray& array);

/// Returns the lowest place, metres, of a hand above \a points (3 x n, metres, n > 0): 1 mm off the
/// one that is farthest along \a up.
Eigen::Vector3d padAbove(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& up);

/// Returns the kit's open right hand (bridge::RoundHand) in its palm's frame, metres,
/// the finest closed mesh of at most \a mostTriangles.
haptics::TriangleMesh handMesh(Eigen::Index mostTriangles);

/// Returns the pose in which that hand comes from \a up (unit length) and points down with its
/// index finger, so that all of it is above \a pad (metres).
Eigen::Isometry3d pointingAt(const Eigen::Vector3d& pad, const Eigen::Vector3d& up);

} // namespace midair::samples
