#pragma once

#include <osg/Vec3>

#include <Eigen/Core>

namespace osgMidair
{

/// A place or direction as graphics cards take it.
inline osg::Vec3 osgVec(const Eigen::Vector3d& v)
{
    return osg::Vec3(
        static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
}

} // namespace osgMidair
