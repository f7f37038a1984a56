#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cstddef>

namespace midair::bridge
{

/// Tracks the poses of one object and extrapolates or interpolates around the newest: along the
/// parabola fitted to the last kMost poses, likewise for rotations. Objects at rest, slow ones and
/// those that jumped stay exactly where they are.
class ObjectMotion
{
public:
    static constexpr std::size_t kMost = 6;
    /// An object moves after it was seen at this many places, each within kLongestGap_s of the one
    /// before and without a jump.
    static constexpr std::size_t kLeast = 3;
    static constexpr double kLongestGap_s = 0.1;
    static constexpr double kWindow_s = 0.1; ///< older places count if there are fewer than four
    /// A step is a jump if it differs from the step before, at the same speed, by more than half of
    /// itself and by more than these limits; a first step if it is faster than kFastest.
    static constexpr double kJump_m = 2e-3;
    static constexpr double kJump_rad = 0.05;
    static constexpr double kFastest = 2.0; ///< m/s; faster objects are extrapolated at this speed
    static constexpr double kFarthest_s = 0.1; ///< limit of the requested time, to either side

    using Corners = Eigen::Matrix<double, 3, 8>;

    /// Adds the pose at \a time_s. An equal pose adds nothing; after one and a half times the last
    /// interval the object is at rest.
    void see(double time_s, const Eigen::Isometry3d& pose);

    bool isMoving() const { return _count >= kLeast; }

    /// Returns the pose \a ahead_s after the newest. \a corners: of the object's box, in its own
    /// frame, for measuring its speed. Objects slower than MotionTrack::kRest stay, so that noise
    /// isn't extrapolated; those faster than kMoving move fully.
    Eigen::Isometry3d at(double ahead_s, const Corners& corners) const;

private:
    using Step = Eigen::Matrix<double, 6, 1>; ///< a way (m) and a turn (axis times angle)
    struct Seen
    {
        double time_s = 0.0;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    };

    static Step between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);
    const Seen& before(std::size_t back) const { return _seen[(_newest + kMost - back) % kMost]; }
    bool isJump(const Seen& next) const;
    void begin(const Seen& seen);
    Step stepTo(double ahead_s) const;

    std::array<Seen, kMost> _seen; ///< a ring
    std::size_t _newest = 0;
    std::size_t _count = 0;
};

} // namespace midair::bridge
