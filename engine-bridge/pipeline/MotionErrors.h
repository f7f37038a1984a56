#pragma once

#include "engine-bridge/display/Coincidence.h"

#include <Eigen/Core>

#include <cstddef>
#include <deque>

namespace midair::bridge
{

/// Measures the distance between where an object was played and where it was seen when the sound
/// arrived. Times are those of its poses.
class MotionErrors
{
public:
    /// An object without motion for this long is at rest: light and sound then agree.
    static constexpr double kRest_s = 0.15;
    static constexpr std::size_t kMost = 64; ///< number of newest errors that count
    static constexpr std::size_t kLeast = 5; ///< errors needed for a known result

    /// Records that the object is seen at \a place at \a time_s.
    void see(double time_s, const Eigen::Vector3d& place);
    /// Records that it is felt at \a place at the time when its light of \a time_s, maybe in the
    /// future, is seen.
    void feel(double time_s, const Eigen::Vector3d& place);

    bool isResting() const { return _seen.size() < 2; }
    MotionError reading() const;

private:
    static constexpr std::size_t kMostSeen = 16;

    struct Placed
    {
        double time_s = 0.0;
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
    };
    void settle(const Placed& felt);

    std::deque<Placed> _seen; ///< in order
    std::deque<Placed> _felt; ///< waiting to be seen
    std::deque<double> _errors_m;
};

} // namespace midair::bridge
