#include "engine-bridge/hands/prediction/MotionTrack.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

MotionTrack::MotionTrack(PredictionMethod method, double measured, double metresPerUnit) :
    _measured(measured),
    _metresPerUnit(metresPerUnit)
{
    for (std::unique_ptr<MotionFilter>& filter : _filters)
        filter = makeMotionFilter(method, motionNoise(measured));
}

void MotionTrack::restart(double time_s, const Eigen::Vector3d& place)
{
    _newest = 0;
    _count = 1;
    _recent[0] = {time_s, place};
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        _filters[static_cast<std::size_t>(axis)]->restart(place[axis]);
}

void MotionTrack::update(double time_s, const Eigen::Vector3d& place)
{
    const double interval_s = time_s - _recent[_newest].time_s;
    _newest = (_newest + 1) % kMost;
    _count = std::min(_count + 1, kMost);
    _recent[_newest] = {time_s, place};
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        _filters[static_cast<std::size_t>(axis)]->update(interval_s, place[axis]);
}

double MotionTrack::pace() const
{
    std::size_t within = kLeast;
    while (within < _count && time_s() - before(within).time_s <= kWindow_s)
        ++within;
    const std::size_t half = within / 2;
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
    double time = 0.0;
    for (std::size_t i = 0; i < half; ++i)
    {
        way += before(i).place - before(within - 1 - i).place;
        time += before(i).time_s - before(within - 1 - i).time_s;
    }
    return way.norm() / time * _metresPerUnit;
}

PredictedShift MotionTrack::predict(double ahead_s) const
{
    if (!isKnown())
        return {Eigen::Vector3d::Zero(),
                std::hypot(_measured, kUnknown / _metresPerUnit * ahead_s)};
    const double speed = pace();
    const double share = std::clamp((speed - kRest) / (kMoving - kRest), 0.0, 1.0);
    const double still = std::hypot(_measured, speed / _metresPerUnit * ahead_s);
    if (share == 0.0) return {Eigen::Vector3d::Zero(), still};
    const double reach = std::clamp(speed / kReach, kLeastReach, 1.0);
    PredictedShift result;
    double sigma = 0.0;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
    {
        const PredictedMotion motion = _filters[static_cast<std::size_t>(axis)]->predict(ahead_s);
        result.shift[axis] = share * (motion.value - place()[axis]);
        sigma = std::max(sigma, std::hypot(motion.noise, reach * motion.lag));
    }
    result.sigma = share * sigma + (1.0 - share) * still;
    return result;
}

} // namespace midair::bridge
