#include "engine-bridge/heads/HeadSource.h"

#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

Eigen::Isometry3d FixedHeadSource::upright(const Eigen::Vector3d& place)
{
    constexpr double kLeast = 1e-6; // of the level part of the way, where z tells no direction
    const Eigen::Vector3d back =
        place.norm() > kLeast ? place.normalized() : Eigen::Vector3d(0.0, -1.0, 0.0);
    const bool isSteep = std::hypot(back.x(), back.y()) <= kLeast;
    const Eigen::Vector3d up = isSteep ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear().col(2) = back;
    pose.linear().col(0) = up.cross(back).normalized();
    pose.linear().col(1) = back.cross(pose.linear().col(0));
    pose.translation() = place;
    return pose;
}

bool FixedHeadSource::headAt(double time_s, Head& head)
{
    head = {time_s, _pose, true, 0.0};
    return true;
}

std::string FixedHeadSource::status() const
{
    const Eigen::Vector3d place = _pose.translation();
    return fmt::format("head fixed at {:g} {:g} {:g} m", place.x(), place.y(), place.z());
}

void InjectedHeadSource::set(const Head& head)
{
    const base::Lock lock(_mutex);
    _head = head;
    if (head.isTracked) ++_set;
}

bool InjectedHeadSource::headAt(double time_s, Head& head)
{
    const base::Lock lock(_mutex);
    head = _head;
    head.isTracked =
        _head.isTracked && std::abs(time_s - _head.time_s) <= _staleAfter_s; // false for NaN
    return head.isTracked;
}

std::string InjectedHeadSource::status() const
{
    const base::Lock lock(_mutex);
    return fmt::format("head set by the application, {} so far", _set);
}

} // namespace midair::bridge
