#pragma once

#include <Eigen/Geometry>

namespace midair::bridge
{

/// An affine map split into a motion and a change of shape: A = pose * stretch.
struct PoseAndStretch
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    /// symmetric; scale, shear and mirroring; baked into vertices
    Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
};

/// Polar decomposition of the affine \a matrix. Returns false if the matrix is not finite, is a
/// perspective, or is singular (smallest scale under 1e-6 of the largest, or under 1e-12).
bool decompose(const Eigen::Matrix4d& matrix, PoseAndStretch& parts);

} // namespace midair::bridge
