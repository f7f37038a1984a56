#pragma once

#include "haptics/sensation/Sensation.h"
#include "haptics/sensation/SensationSample.h"
#include "haptics/sensation/SensationValues.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace midair::haptics
{

/// The point of the path at a time of a pattern, and what is drawn round it.
struct TrackPoint
{
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero(); ///< after the pattern's transform
    double intensity = 0.0;                                ///< without the brush's modulation
    DrawnBrush brush;
    bool isStopped = false;
};

/// A jump that is taken.
struct TakenJump
{
    double at_ms; ///< time of its keyframe in the pattern
    double to_ms;
};

/// A pattern's properties at times of the pattern: mixes those of the keyframes before and after.
/// All functions are pure, and don't allocate. Any thread.
class SensationTrack
{
public:
    explicit SensationTrack(std::shared_ptr<const Sensation> sensation);

    const Sensation& sensation() const { return *_sensation; }

    /// Returns the point at \a time_ms of the pattern. \a draws: uniform in 0 .. 1, for random
    /// intensities before and after.
    TrackPoint
    at(double time_ms, const SensationValues& values, const std::array<double, 2>& draws) const;
    DrawnBrush brushAt(double time_ms, const SensationValues& values) const;

    /// Returns true if nothing changes after \a time_ms, or, unless time \a passes in the pattern,
    /// at it: no keyframe follows, and the intensity isn't random.
    bool isSteady(double time_ms, bool passes) const;

    /// Returns the first jump whose condition holds, of keyframes with \a after_ms < time <= \a
    /// until_ms.
    std::optional<TakenJump>
    jump(double after_ms, double until_ms, const SensationValues& values) const;

    /// Returns the time of the first keyframe after, or the last one before \a time_ms; infinite if
    /// there is none.
    double nextKeyframe_ms(double time_ms) const;
    double previousKeyframe_ms(double time_ms) const;

private:
    /// A property's keyframe, and the time that counts as its own: a pause or stop moves it.
    struct Key
    {
        int index = -1; ///< -1: none
        double time_ms = 0.0;
    };
    struct Keys
    {
        Key position;
        Key brush;
        Key intensity;
    };
    /// From a keyframe to the next one.
    struct Span
    {
        Keys before;
        Keys after;
        bool isStopped = false; ///< it begins with a stop
        bool isMoving = false;  ///< it ends with a standard keyframe
    };

    void meet(std::size_t index, Keys& keys) const;
    const Span& spanAt(double time_ms) const;
    const SensationKeyframe& frame(const Key& key) const
    {
        return _sensation->keyframes[static_cast<std::size_t>(key.index)];
    }
    Eigen::Vector3d positionIn(const Span& span, double time_ms) const;
    Eigen::Vector3d transformed(const Eigen::Vector3d& at, const SensationValues& values) const;
    double intensityIn(const Span& span,
                       double time_ms,
                       const SensationValues& values,
                       const std::array<double, 2>& draws) const;
    DrawnBrush brushIn(const Span& span, double time_ms, const SensationValues& values) const;

    std::shared_ptr<const Sensation> _sensation;
    std::vector<double> _times_ms;     ///< of the keyframes
    std::vector<Span> _spans;          ///< one more than keyframes: the first is before all of them
    std::vector<std::size_t> _jumpers; ///< keyframes with jumps
};

} // namespace midair::haptics
