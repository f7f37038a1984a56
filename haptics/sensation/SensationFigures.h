#pragma once

#include "haptics/sensation/SensationPlayer.h"

#include <Eigen/Core>

#include <cmath>
#include <optional>

namespace midair::haptics
{

/// What of a pattern decides if and how an array can play it.
struct SensationFigures
{
    /// corners of the box round all samples that aren't silent; NaN: all are
    Eigen::Vector3d low_mm = Eigen::Vector3d::Constant(std::nan(""));
    Eigen::Vector3d high_mm = Eigen::Vector3d::Constant(std::nan(""));
    /// time until the pattern stops; none: it doesn't within the time that was measured
    std::optional<double> duration_ms;
    double speed_m_s = 0.0;     ///< median speed of the focus while it isn't silent
    double draw_Hz = 0.0;       ///< highest rate of turns of a brush that has a size; 0: none
    double modulation_Hz = 0.0; ///< highest frequency of the amplitude modulation
    double mostIntensity = 0.0; ///< 0 .. 1
    bool isLimited = false;     ///< the pattern asks for an intensity outside 0 .. 1
    bool isBroken = false;      ///< a sample isn't finite

    /// Returns the fields of a turn of the brush at \a rate_Hz fields a second; infinite without
    /// turns. Below kLeastPoints the path isn't felt as drawn.
    double pointsPerTurn(double rate_Hz) const;

    static constexpr double kLeastPoints = 8.0;
};

/// Measures a pattern with the parameters that are set in \a player, which it plays from the start
/// until the pattern stops, at most \a most_ms, in steps of SensationPlayer::kStep_ms.
SensationFigures measureSensation(SensationPlayer& player, double most_ms = 10000.0);

} // namespace midair::haptics
