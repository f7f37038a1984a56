#include "engine-bridge/pipeline/ObjectMotion.h"

#include "engine-bridge/hands/prediction/MotionTrack.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

Eigen::Isometry3d moved(const Eigen::Isometry3d& pose, const Eigen::Matrix<double, 6, 1>& step)
{
    Eigen::Isometry3d result = pose;
    result.translation() += step.head<3>();
    const double angle = step.tail<3>().norm();
    if (angle > 0.0)
        result.linear() =
            Eigen::AngleAxisd(angle, step.tail<3>() / angle).toRotationMatrix() * pose.linear();
    return result;
}

double farthestWay_m(const ObjectMotion::Corners& corners,
                     const Eigen::Isometry3d& a,
                     const Eigen::Isometry3d& b)
{
    return (b * corners - a * corners).colwise().norm().maxCoeff();
}

} // namespace

ObjectMotion::Step ObjectMotion::between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to)
{
    Step step;
    step.head<3>() = to.translation() - from.translation();
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.linear() * from.linear().transpose()));
    step.tail<3>() = turn.angle() * turn.axis();
    return step;
}

void ObjectMotion::begin(const Seen& seen)
{
    _newest = 0;
    _count = 1;
    _seen[0] = seen;
}

bool ObjectMotion::isJump(const Seen& next) const
{
    const Seen& last = before(0);
    const Step step = between(last.pose, next.pose);
    const double interval_s = next.time_s - last.time_s;
    if (_count < 2) return step.head<3>().norm() > kFastest * interval_s;
    const Step expected =
        between(before(1).pose, last.pose) * (interval_s / (last.time_s - before(1).time_s));
    const auto isOff = [&](int first, double least)
    {
        const double off = (step - expected).segment<3>(first).norm();
        return off > std::max(least, 0.5 * step.segment<3>(first).norm());
    };
    return isOff(0, kJump_m) || isOff(3, kJump_rad);
}

void ObjectMotion::see(double time_s, const Eigen::Isometry3d& pose)
{
    const Seen next{time_s, pose};
    const double interval_s = time_s - before(0).time_s;
    const bool isKnown = _count > 0 && interval_s >= 0.0 && pose.matrix().allFinite();
    if (isKnown && pose.matrix() == before(0).pose.matrix())
    {
        // The first of two equal poses tells when the object arrived.
        if (_count > 1 && interval_s > 1.5 * (before(0).time_s - before(1).time_s)) begin(next);
        return;
    }
    if (!isKnown || !(interval_s > 0.0) || interval_s > kLongestGap_s || isJump(next))
        return begin(next);
    _newest = (_newest + 1) % kMost;
    _count = std::min(_count + 1, kMost);
    _seen[_newest] = next;
}

// The least squares parabola through the steps from the newest pose, or a line if few are known.
// Only its path after the newest pose counts.
ObjectMotion::Step ObjectMotion::stepTo(double ahead_s) const
{
    std::size_t count = std::min<std::size_t>(_count, kLeast + 1);
    while (count < _count && before(0).time_s - before(count).time_s <= kWindow_s)
        ++count;
    const double span_s = before(0).time_s - before(count - 1).time_s;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 6, 3> moments = Eigen::Matrix<double, 6, 3>::Zero();
    for (std::size_t i = 0; i < count; ++i)
    {
        const double t = (before(i).time_s - before(0).time_s) / span_s;
        const Eigen::Vector3d powers(1.0, t, t * t);
        normal += powers * powers.transpose();
        moments += between(before(0).pose, before(i).pose) * powers.transpose();
    }
    const double h = ahead_s / span_s;
    if (count == kLeast)
    {
        const Eigen::Matrix2d line = normal.topLeftCorner<2, 2>().inverse();
        return moments.leftCols<2>() * line.col(1) * h;
    }
    const Eigen::Matrix3d inverse = normal.inverse();
    return moments * (inverse.col(1) * h + inverse.col(2) * h * h);
}

Eigen::Isometry3d ObjectMotion::at(double ahead_s, const Corners& corners) const
{
    const Eigen::Isometry3d& newest = before(0).pose;
    const double asked_s = std::clamp(ahead_s, -kFarthest_s, kFarthest_s);
    if (!isMoving() || asked_s == 0.0) return newest;
    const Step step = stepTo(asked_s);
    const double speed = farthestWay_m(corners, newest, moved(newest, step)) / std::abs(asked_s);
    if (!(speed > MotionTrack::kRest)) return newest; // also for NaN
    const double share =
        std::min({1.0,
                  (speed - MotionTrack::kRest) / (MotionTrack::kMoving - MotionTrack::kRest),
                  kFastest / speed});
    return moved(newest, share * step);
}

} // namespace midair::bridge
