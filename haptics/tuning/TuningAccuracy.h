#pragma once

#include "haptics/tuning/RehearsedInstrument.h"
#include "haptics/tuning/TuningFit.h"

namespace midair::haptics
{

/// How near a fit came to what a rehearsal hid.
struct TuningAccuracy
{
    double phaseError_rad = 0.0; ///< rms over transducers found alive, but for a common phase
    int reversedWrong = 0;       ///< off by more than 90 degrees: of the other polarity
    int dead = 0;                ///< hidden
    int deadFound = 0;           ///< of those
    int deadWrong = 0;           ///< alive, and called dead
    double gainError = 0.0;      ///< rms, relative to the median gain
    /// Least amplitude of a focus with the found offsets, over that with the hidden ones, of foci
    /// at the first place and 2 cm beside it along each axis.
    double focus = 0.0;
    Eigen::Matrix3Xd placeErrors_m; ///< 3 x P, found less hidden
};

TuningAccuracy accuracyOf(const TuningFit& fit, const RehearsedInstrument& hidden);

} // namespace midair::haptics
