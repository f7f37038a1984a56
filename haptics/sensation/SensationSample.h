#pragma once

#include <Eigen/Core>

namespace midair::haptics
{

/// The brush at an instant; see SensationBrush.
struct DrawnBrush
{
    double x_mm = 0.0;
    double y_mm = 0.0;
    double a = 1.0;
    double b = 1.0;
    double phase_rad = 0.0;
    double rotation_rad = 0.0;
    double draw_Hz = 0.0;       ///< turns a second
    double modulation_Hz = 0.0; ///< of the amplitude; 0: none

    /// Returns the place on the curve at \a angle_rad, in mm from the point of the path.
    Eigen::Vector2d at(double angle_rad) const;
    /// Returns true if a turn draws more than a point.
    bool isDrawn() const { return (x_mm != 0.0 && a != 0.0) || (y_mm != 0.0 && b != 0.0); }
};

/// The focus of a pattern at an instant.
struct SensationSample
{
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d path_mm = Eigen::Vector3d::Zero(); ///< the same without the brush
    double intensity = 0.0;                            ///< share of its pressure
    double patternTime_ms = 0.0; ///< time in the pattern, which jumps and speed change
    bool isStopped = false;      ///< the pattern has ended
    bool isFinite = true;        ///< false: a formula gave NaN or infinity
    bool isLimited = false;      ///< the pattern asks for an intensity outside 0 .. 1
    bool isOutline = false; ///< fields are too slow for the brush: position_mm is the path's point,
                            ///< and all of the curve round it is meant at once
    bool isUnmodulated = false; ///< fields are too slow for the modulation, which is left out
    DrawnBrush brush;
};

} // namespace midair::haptics
