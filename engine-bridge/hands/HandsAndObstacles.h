#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// The hands and props in the array frame, and how they affect the field.
struct HandsAndObstacles
{
    std::vector<HandCapsule> hands;
    /// real objects in the sound's way, not those that are only rendered
    std::vector<Capsule> props;
    /// > 0: only points within this of a hand's skin are solved; 0: all, hands or none
    double reach_m = 0.0;
    bool shadows = false; ///< if true, hands and props shadow transducers
};

/// Hands and props that moved by no more than this, m, count as unmoved. It is a fifth of a
/// wavelength or less for existing devices.
constexpr double kHandTolerance_m = 1e-3;

/// Returns true if the field for \a a also fits \a b: everything that affects it is the same, and
/// moved by no more than kHandTolerance_m.
bool equivalent(const HandsAndObstacles& a, const HandsAndObstacles& b);

/// Applies a HandsAndObstacles to control points and to the array.
class ReachAndShadow
{
public:
    /// Returns true if \a now is equivalent to the argument of the last begin().
    bool unmoved(const HandsAndObstacles& now) const { return equivalent(now, _last); }

    /// Sets the hands and props for the calls that follow.
    void begin(const HandsAndObstacles& now) { _last = now; }

    /// Moves the points farther than reach_m from all hands from \a points to \a skipped, and
    /// returns their number. If reach_m is 0, all points stay.
    std::uint64_t keepWithinReach(haptics::ControlPoints& points, Eigen::Matrix3Xd& skipped) const;

    /// A copy of \a array with lower gains for transducers that hands and props shadow from
    /// \a points, or \a array itself without shadows; valid until the next call.
    const haptics::TransducerArray& shadowed(const haptics::ControlPoints& points,
                                             const haptics::TransducerArray& array,
                                             double wavelength_m);

private:
    HandsAndObstacles _last;
    haptics::TransducerArray _shadowed;
};

} // namespace midair::bridge
