#pragma once

#include "engine-bridge/hands/prediction/MotionFilter.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <memory>

namespace midair::bridge
{

/// How far something has gone since it was last measured.
struct PredictedShift
{
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(); ///< u, to be added to the last measurement
    double sigma = 0.0;                              ///< u, > 0; expected error of the place then
};

/// Follows three coordinates that belong together, and predicts them less and less as they come to
/// rest: a prediction multiplies noise, and overshoots what has stopped.
class MotionTrack
{
public:
    /// What moves slower than this (m/s) isn't predicted at all, and what is faster than the second
    /// wholly; in between it is by a share that rises with the pace: half of it at 0.05 m/s, which
    /// is 3.5 mm in 70 ms. Lower ones let the noise of a tracker that sees each joint apart
    /// through.
    static constexpr double kRest = 0.035;
    static constexpr double kMoving = 0.07;
    /// The pace is that between the means of the two halves of the last measurements: those of this
    /// time, and kLeast at least.
    static constexpr double kWindow_s = 0.1;
    static constexpr std::size_t kLeast = 4;
    /// What is this fast (m/s) has the accelerations that MotionNoise assumes; what is slower has
    /// less, in proportion, as reaches of one duration have, but a tenth at least.
    static constexpr double kReach = 0.5;
    static constexpr double kLeastReach = 0.1;
    /// The speed (m/s) that something may have whose pace isn't known yet, for its sigma.
    static constexpr double kUnknown = 1.0;

    /// \a measured: noise of a coordinate, u (m or rad), > 0. \a metresPerUnit: what a u comes to
    /// on the skin; 1 for places, for turns the lever's length in m. \a method: one that has a
    /// filter.
    MotionTrack(PredictionMethod method, double measured, double metresPerUnit);

    /// Forgets all but \a place, and begins with it at \a time_s.
    void restart(double time_s, const Eigen::Vector3d& place);

    /// Takes the measurement \a place at \a time_s, which has to be after the last one's.
    void update(double time_s, const Eigen::Vector3d& place);

    /// The way from the last measurement to the place \a ahead_s (>= 0) after it.
    PredictedShift predict(double ahead_s) const;

    /// The skin's speed, m/s. Only for kLeast measurements or more: isKnown().
    double pace() const;
    bool isKnown() const { return _count >= kLeast; }
    const Eigen::Vector3d& place() const { return _recent[_newest].place; }
    double time_s() const { return _recent[_newest].time_s; }

private:
    static constexpr std::size_t kMost = 64;

    struct Measurement
    {
        double time_s = 0.0;
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
    };

    /// The measurement \a back before the newest.
    const Measurement& before(std::size_t back) const
    {
        return _recent[(_newest + kMost - back) % kMost];
    }

    std::array<std::unique_ptr<MotionFilter>, 3> _filters;
    double _measured;
    double _metresPerUnit;
    std::array<Measurement, kMost> _recent; ///< a ring
    std::size_t _newest = 0;
    std::size_t _count = 0;
};

} // namespace midair::bridge
