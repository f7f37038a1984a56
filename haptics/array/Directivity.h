#pragma once

#include <string>

namespace midair::haptics
{

/// Model of how a transducer's amplitude decreases with the angle theta from its normal; D(0) = 1,
/// D >= 0.
enum class Directivity
{
    T4010A1_HARMONICS, ///< the paper's zonal harmonics of order 0..3; -2.2 dB at 50 degrees
    T4010A1_TABLE, ///< its data sheet's, measured at 0, 10, .. 90 degrees; -6 dB at 50; 0 behind
    POINT          ///< D = 1
};

/// Returns D(theta) of \a model at cos(theta) = \a cosTheta in [-1, 1].
double directivity(Directivity model, double cosTheta);

/// Returns "t4010a1-harmonics", "t4010a1-table" or "point".
const char* directivityName(Directivity model);
/// Returns the model of that name. Throws InputError, with the known names, for any other.
Directivity directivityFromName(const std::string& name);

} // namespace midair::haptics
