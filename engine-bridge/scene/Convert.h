#pragma once

#include "engine-bridge/PoseAndStretch.h"

#include <osg/Matrixd>
#include <osg/Quat>
#include <osg/Vec3d>

#include <Eigen/Geometry>

namespace midair::bridge
{

/// Convert between OSG's matrices for row vectors (v M) and Eigen's for column vectors (M v), which
/// are each other's transpose. No other code transposes.
inline Eigen::Matrix4d toEigen(const osg::Matrixd& matrix)
{
    // OSG stores row by row; Eigen reads this column by column, which gives the transpose.
    return Eigen::Map<const Eigen::Matrix4d>(matrix.ptr());
}
inline osg::Matrixd toOsg(const Eigen::Matrix4d& matrix)
{
    return osg::Matrixd(matrix.data());
}

inline Eigen::Vector3d toEigen(const osg::Vec3d& v)
{
    return {v.x(), v.y(), v.z()};
}
inline osg::Vec3d toOsg(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

inline Eigen::Quaterniond toEigen(const osg::Quat& q)
{
    return {q.w(), q.x(), q.y(), q.z()};
}
inline osg::Quat toOsg(const Eigen::Quaterniond& q)
{
    return {q.x(), q.y(), q.z(), q.w()};
}

} // namespace midair::bridge
