#pragma once

#include <Eigen/Geometry>

#include <deque>
#include <optional>

namespace midair::bridge
{

/// Finds places where a fingertip is held still, from samples of a tracker. Averaging over the
/// holding time removes the tracker's jitter.
class StillTip
{
public:
    /// A fingertip with the head's place, if known; world, m.
    struct Sample
    {
        Eigen::Vector3d tip = Eigen::Vector3d::Zero();
        Eigen::Isometry3d head = Eigen::Isometry3d::Identity();
    };

    /// \a hold_s: required holding time; \a still_m: allowed distance from the mean; \a away_m:
    /// required distance between two places.
    explicit StillTip(double hold_s = 1.0, double still_m = 0.015, double away_m = 0.03) :
        _hold_s(hold_s),
        _still_m(still_m),
        _away_m(away_m)
    {
    }

    /// Adds the sample at \a time_s, which never decreases; none: not seen, which starts again.
    /// Returns the means once it was still for long enough: once per place.
    std::optional<Sample> add(double time_s, const std::optional<Sample>& sample);

private:
    struct Seen
    {
        double time_s;
        Sample sample;
    };

    double _hold_s, _still_m, _away_m;
    std::deque<Seen> _seen;                ///< of the last _hold_s
    std::optional<Eigen::Vector3d> _taken; ///< the last place found, until the tip leaves it
};

} // namespace midair::bridge
