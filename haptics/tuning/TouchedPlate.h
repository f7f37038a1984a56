#pragma once

#include "haptics/array/Reflector.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// A flat rectangle, found by touching it with a tracked tip: a first guess for fitReflector().
struct TouchedPlate
{
    Reflector reflector; ///< accuracy_mm is the standard error of the plane at its middle
    double off_m = 0.0;  ///< rms distance of the touched places from its plane

    /// Returns the smallest rectangle around \a touched (3 x n, metres, n >= 4; the corners of the
    /// plate, and any other places on it) in their plane of least squares. Its normal points
    /// towards \a from (metres), where the sound comes from. Throws InputError for fewer places,
    /// such as aren't finite or lie within 10 mm of a line, and for one over 6 mm off the plane,
    /// farther than fitReflector() looks.
    static TouchedPlate at(const Eigen::Matrix3Xd& touched, const Eigen::Vector3d& from);
};

} // namespace midair::haptics
