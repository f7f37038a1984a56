#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// The hands and props in the array frame, and how the field takes them into account.
struct HandsAndObstacles
{
    std::vector<HandCapsule> hands;
    /// real things that are in the sound's way; never what is only seen
    std::vector<Capsule> props;
    /// > 0: only points within this of a hand's skin are solved; 0: all, hands or none
    double reach_m = 0.0;
    bool shadows = false; ///< hands and props take transducers' sound away
};

/// Movements by less than this (m) change nothing. It is a fifth of a wavelength or less of the
/// devices that exist.
constexpr double kHandTolerance_m = 1e-3;

/// True if the field for \a a is also the field for \a b: all that matters of them is the same, and
/// none of it moved by more than the tolerance.
bool equivalent(const HandsAndObstacles& a, const HandsAndObstacles& b);

/// Applies a HandsAndObstacles to control points and to the array, and remembers it until the next
/// one.
class ReachAndShadow
{
public:
    /// True where \a now is equivalent to what was last given to begin().
    bool unmoved(const HandsAndObstacles& now) const { return equivalent(now, _last); }

    void begin(const HandsAndObstacles& now) { _last = now; }

    /// Moves the points that no hand can reach from \a points to \a skipped, and returns how many.
    /// Where reach_m is 0 all stay.
    std::uint64_t keepWithinReach(haptics::ControlPoints& points, Eigen::Matrix3Xd& skipped) const;

    /// A copy of \a array with its gains lowered where hands and props are between it and \a
    /// points; valid until the next call.
    const haptics::TransducerArray& shadowed(const haptics::ControlPoints& points,
                                             const haptics::TransducerArray& array,
                                             double wavelength_m);

private:
    HandsAndObstacles _last;
    haptics::TransducerArray _shadowed;
};

} // namespace midair::bridge
