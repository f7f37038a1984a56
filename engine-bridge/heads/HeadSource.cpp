#include "engine-bridge/heads/HeadSource.h"

#include "engine-bridge/hands/HandRecording.h"
#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <sstream>

#include <fmt/format.h>

namespace midair::bridge
{

Eigen::Isometry3d FixedHeadSource::upright(const Eigen::Vector3d& place)
{
    constexpr double kLeast = 1e-6; // of the horizontal part, below which z gives no direction
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

RecordedHeadSource::RecordedHeadSource(const std::string& path, bool loop) :
    _name(path),
    _loop(loop)
{
    std::istringstream in(recordingIn(path));
    read(in);
}

RecordedHeadSource::RecordedHeadSource(std::istream& in, const std::string& name, bool loop) :
    _name(name),
    _loop(loop)
{
    read(in);
}

void RecordedHeadSource::read(std::istream& in)
{
    readRecording(in,
                  _name,
                  [&](const RecordedRow& row) -> std::string
                  {
                      if (row.joint != RecordedRow::kHead) return {};
                      if (!_heads.empty() && !(row.time_s > _heads.back().time_s))
                          return fmt::format("time {:g} isn't after that of the head above it",
                                             row.time_s);
                      if (_heads.size() == kMostRecordedFrames)
                          return "more than 200000 heads, which are the most possible";
                      const HandJoint& value = row.value;
                      _heads.push_back({row.time_s,
                                        headPose(value.position, value.orientation),
                                        value.positionValid && value.orientationValid,
                                        0.0});
                      return {};
                  });
    if (_heads.empty())
        throw base::InputError(_name + ": no head in it; a line is " + kRecordedHeadings +
                               " with head as the joint");
}

bool RecordedHeadSource::headAt(double time_s, Head& head)
{
    const double t = recordedTime(time_s, _heads.back().time_s, _loop);
    head = {time_s, Eigen::Isometry3d::Identity(), false, 0.0};
    const auto after =
        std::lower_bound(_heads.begin(),
                         _heads.end(),
                         t,
                         [](const Head& h, double value) { return h.time_s < value; });
    if (after == _heads.end() || (after == _heads.begin() && after->time_s != t)) return false;
    const Head& b = *after;
    const Head& a = b.time_s == t ? b : *(after - 1);
    const double gap = b.time_s - a.time_s;
    if (!a.isTracked || !b.isTracked || gap > kLongestGap_s) return false;
    const double share = gap > 0.0 ? (t - a.time_s) / gap : 0.0;
    const Eigen::Quaterniond from(a.pose.linear());
    head.pose = headPose((1.0 - share) * a.pose.translation() + share * b.pose.translation(),
                         from.slerp(share, Eigen::Quaterniond(b.pose.linear())));
    head.isTracked = true;
    return true;
}

std::string RecordedHeadSource::status() const
{
    return fmt::format("{}: {} recorded heads", _name, _heads.size());
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
        _head.isTracked && std::abs(time_s - _head.time_s) <= _staleAfter_s; // also false for NaN
    return head.isTracked;
}

std::string InjectedHeadSource::status() const
{
    const base::Lock lock(_mutex);
    return fmt::format("head set by the application, {} so far", _set);
}

} // namespace midair::bridge
