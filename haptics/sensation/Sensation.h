#pragma once

#include "haptics/sensation/SensationNumber.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace midair::haptics
{

/// A parameter of a pattern, which a program sets while it plays.
struct SensationParameter
{
    std::string name;
    double standard = 0.0;      ///< the value until it is set
    std::optional<double> low;  ///< values below are raised to it
    std::optional<double> high; ///< values above are lowered to it; >= low
    bool isDefined = true;      ///< false: the pattern uses the name without defining it
};

/// How a property gets from its keyframe to the next one that has it.
enum class SensationTransition
{
    LINEAR,
    STEP ///< it keeps its value until the next
};

/// The curve on which the focus turns round the path. At angle u = 2 pi f t it is at
/// (x sin(a u + phase), y sin(b u)), turned by the rotation about z.
struct SensationBrush
{
    enum class Kind
    {
        CIRCLE,   ///< x = y = radius, a = b = 1, phase = pi/2
        LINE,     ///< y = 0, a = 1, phase = pi/2: it spans -x .. x
        LISSAJOUS ///< of all kinds it alone has a, b, phase and y of its own
    };

    Kind kind = Kind::CIRCLE;
    SensationNumber x_mm;
    SensationNumber y_mm;
    SensationNumber a = 1.0;
    SensationNumber b = 1.0;
    SensationNumber phase_rad;
    SensationNumber rotation; ///< of a line in degrees, of a Lissajous curve in radians
    SensationNumber draw_Hz = 100.0;
    SensationNumber modulation_Hz; ///< 0: none
};

/// Strength of the focus, a share of its pressure; nominally 0 .. 1.
struct SensationIntensity
{
    SensationNumber low;
    SensationNumber high; ///< a random one is uniform in low .. high, a constant one is low
    bool isRandom = false;
};

/// Goes to another time of the pattern if a condition holds when its keyframe is passed.
struct SensationJump
{
    enum class Comparison
    {
        LESS,
        LESS_OR_EQUAL,
        GREATER,
        GREATER_OR_EQUAL
    };

    std::size_t parameter = 0; ///< index; an unknown value fulfils no condition
    Comparison comparison = Comparison::LESS;
    double value = 0.0;
    double to_ms = 0.0;
};

/// Properties at a time of the pattern.
struct SensationKeyframe
{
    enum class Kind
    {
        STANDARD, ///< has a position
        PAUSE,    ///< holds the position
        STOP      ///< ends the pattern; has nothing else
    };

    Kind kind = Kind::STANDARD;
    double time_ms = 0.0;
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    SensationTransition positionTransition = SensationTransition::LINEAR;
    std::optional<SensationBrush> brush;
    SensationTransition brushTransition = SensationTransition::LINEAR;
    std::optional<SensationIntensity> intensity;
    SensationTransition intensityTransition = SensationTransition::LINEAR;
    std::vector<SensationJump> jumps;
};

/// Applied to the path, in this order; not to the brush.
struct SensationTransform
{
    std::array<SensationNumber, 3> scale = {1.0, 1.0, 1.0};
    SensationNumber rotation_deg; ///< about z
    std::array<SensationNumber, 3> translation_mm = {0.0, 0.0, 0.0};
};

/// A pattern of a focus in time: what designers of mid-air haptics make. Its keyframes move a point
/// along a path, a brush draws a curve round the point, both with parameters. The model is that of
/// AdapTics (John, Li, Seifi, CHI 2024, 10.1145/3613904.3642090). Position in mm, time in ms, z
/// away from the skin or the array.
struct Sensation
{
    static constexpr std::size_t kMostKeyframes = 10000;
    static constexpr std::size_t kMostParameters = 1000;

    std::string name;
    std::vector<SensationParameter> parameters;
    std::vector<SensationKeyframe> keyframes; ///< in order of time
    SensationTransform transform;
    SensationNumber intensityFactor = 1.0;
    SensationNumber speed = 1.0;
    /// turns; phase of the amplitude modulation at the start: 0 begins at full intensity, 0.5 at
    /// none
    double modulationStart = 0.0;

    /// Returns the index of the parameter \a name; none: parameters.size().
    std::size_t parameterIndex(const std::string& name) const;
    /// Returns the index of the parameter \a name, which is added, not defined, if there is none.
    /// Throws InputError above kMostParameters.
    std::size_t usedParameter(const std::string& name);
};

} // namespace midair::haptics
