#pragma once

#include <osg/Matrixd>
#include <osg/Vec3d>

#include <Eigen/Geometry>

namespace midair::bridge
{

/// OSG multiplies row vectors (v M), Eigen column vectors (M v): the transpose, and the only place
/// where it is taken.
Eigen::Matrix4d toEigen(const osg::Matrixd& matrix);
osg::Matrixd toOsg(const Eigen::Matrix4d& matrix);

inline Eigen::Vector3d toEigen(const osg::Vec3d& v)
{
    return {v.x(), v.y(), v.z()};
}
inline osg::Vec3d toOsg(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

/// An affine map taken apart into what moves an object and what changes its shape: A = pose *
/// stretch.
struct PoseAndStretch
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    /// symmetric; scale, shear and mirroring; baked into vertices
    Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
};

/// Polar decomposition of the affine \a matrix. False where it can't be felt: not finite,
/// perspective, or singular (smallest scale under 1e-6 of the largest, or under 1e-12).
bool decompose(const Eigen::Matrix4d& matrix, PoseAndStretch& parts);

} // namespace midair::bridge
