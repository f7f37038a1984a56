#include "engine-bridge/pipeline/MotionErrors.h"

#include "haptics/base/Percentile.h"

#include <vector>

namespace midair::bridge
{

void MotionErrors::see(double time_s, const Eigen::Vector3d& place)
{
    const bool isSame = !_seen.empty() && place == _seen.back().place;
    if (!_seen.empty() && time_s <= _seen.back().time_s) return;
    double last_s = time_s;
    for (const Placed& one : _seen)
        if (one.place != place) last_s = one.time_s;
    if (isSame && (time_s - last_s > kRest_s || isResting()))
    {
        _seen.assign(1, {time_s, place});
        _felt.clear();
        _errors_m.clear();
        return;
    }
    _seen.push_back({time_s, place});
    if (_seen.size() > kMostSeen) _seen.pop_front();
    while (!_felt.empty() && _felt.front().time_s <= time_s)
    {
        settle(_felt.front());
        _felt.pop_front();
    }
}

void MotionErrors::feel(double time_s, const Eigen::Vector3d& place)
{
    if (isResting()) return;
    if (time_s <= _seen.back().time_s) return settle({time_s, place});
    _felt.push_back({time_s, place});
    if (_felt.size() > kMostSeen) _felt.pop_front();
}

// Interpolates between the places where it was seen.
void MotionErrors::settle(const Placed& felt)
{
    for (std::size_t i = 1; i < _seen.size(); ++i)
    {
        const Placed& from = _seen[i - 1];
        const Placed& to = _seen[i];
        if (felt.time_s < from.time_s || felt.time_s > to.time_s) continue;
        const double share = (felt.time_s - from.time_s) / (to.time_s - from.time_s);
        _errors_m.push_back((felt.place - from.place - share * (to.place - from.place)).norm());
        if (_errors_m.size() > kMost) _errors_m.pop_front();
        return;
    }
}

MotionError MotionErrors::reading() const
{
    MotionError error;
    if (isResting()) return {!_seen.empty(), 0.0, 0.0};
    if (_errors_m.size() < kLeast) return error;
    const std::vector<double> all(_errors_m.begin(), _errors_m.end());
    return {true, base::percentile(all, 0.5), base::percentile(all, 0.95)};
}

} // namespace midair::bridge
