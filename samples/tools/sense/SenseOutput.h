#pragma once

#include "haptics/sensation/SensationValues.h"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// Names and values of a pattern's parameters.
using SenseParameters = std::vector<std::pair<std::string, double>>;

/// Returns the parameters that have a value.
inline SenseParameters valuesOf(const haptics::SensationValues& values)
{
    SenseParameters all;
    const std::vector<std::string> names = values.names();
    for (std::size_t index = 0; index < names.size(); ++index)
        if (values.isKnown(index)) all.emplace_back(names[index], values[index]);
    return all;
}

/// A tracked hand beside a pattern.
struct SenseHand
{
    static constexpr int kJoints = 26;

    bool isLeft = false;
    /// m, in the pattern's frame, in the order of OpenXR's XR_EXT_hand_tracking
    Eigen::Matrix<double, 3, kJoints> joints = Eigen::Matrix<double, 3, kJoints>::Zero();
    Eigen::Matrix<double, kJoints, 1> radii_m = Eigen::Matrix<double, kJoints, 1>::Zero();
    /// of the palm: -z towards the fingers, +y out of the back of the hand
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
};

/// Where a pattern is felt: an array, or its stand-in in a test. It is silent until begin().
/// Functions may throw InputError with what is refused; then nothing has changed.
class SenseOutput
{
public:
    virtual ~SenseOutput() = default;

    /// Plays \a sensation, the JSON text of a pattern, the path of a file, or a classic, from the
    /// same time on.
    virtual void setSensation(const std::string& sensation) = 0;
    /// Sets parameters. Others keep their values.
    virtual void setParameters(const SenseParameters& parameters) = 0;
    /// Turns and moves the pattern in its place: a rotation and a translation, m.
    virtual void setTransform(const Eigen::Matrix4d& transform) = 0;
    /// Plays on the palm of a tracked hand, or in the pattern's place.
    virtual void setTracking(bool isTracking) = 0;
    virtual void begin() = 0; ///< plays from time 0 on
    virtual void end() = 0;   ///< falls silent; doesn't throw
    /// Returns the first hand whose joints are all known, as of the last update(); none: there is
    /// no such hand.
    virtual std::optional<SenseHand> hand() const = 0;
    /// Keeps the array playing; call it 60 times a second. \a time_s: of the steady clock.
    virtual void update(double time_s) = 0;
};

} // namespace midair::samples
