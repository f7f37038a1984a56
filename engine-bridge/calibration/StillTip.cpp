#include "engine-bridge/calibration/StillTip.h"

#include <cmath>

namespace midair::bridge
{

std::optional<StillTip::Sample> StillTip::add(double time_s, const std::optional<Sample>& sample)
{
    if (!sample || !sample->tip.allFinite())
    {
        _seen.clear();
        return {};
    }
    if (_taken && (sample->tip - *_taken).norm() < _away_m) return {};
    _taken.reset();
    _seen.push_back({time_s, *sample});
    Sample mean;
    Eigen::Vector3d heads = Eigen::Vector3d::Zero();
    for (const Seen& one : _seen)
    {
        mean.tip += one.sample.tip;
        heads += one.sample.head.translation();
    }
    const auto count = static_cast<double>(_seen.size());
    mean.tip /= count;
    mean.head = sample->head;
    mean.head.translation() = heads / count;
    for (const Seen& one : _seen)
    {
        if ((one.sample.tip - mean.tip).norm() <= _still_m) continue;
        _seen.clear();
        _seen.push_back({time_s, *sample});
        return {};
    }
    if (time_s - _seen.front().time_s < _hold_s) return {};
    _seen.clear();
    _taken = mean.tip;
    return mean;
}

} // namespace midair::bridge
