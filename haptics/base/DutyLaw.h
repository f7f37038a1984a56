#pragma once

#include "haptics/base/Units.h"

#include <cmath>

namespace midair::base
{

/// A transducer is driven by one pulse per ultrasound period and emits the pulse's fundamental. A
/// pulse that lasts a fraction d of the period, 0 .. 1/2, gives the relative amplitude sin(pi d), 0
/// .. 1. Duty levels count d in units of 1/510, so level 255, the largest byte, is half a period:
/// full drive.
constexpr int kDutyPeriod = 510;
constexpr int kFullDuty = 255;

/// Returns the relative amplitude, 0 .. 1, of duty level \a level, 0 .. kFullDuty, which may be
/// fractional.
inline double dutyAmplitude(double level)
{
    return std::sin(kPi * level / kDutyPeriod);
}

/// Returns the duty level, 0 .. kFullDuty and not rounded, of a relative amplitude of 0 .. 1.
inline double dutyLevel(double amplitude)
{
    return kDutyPeriod / kPi * std::asin(amplitude);
}

/// Returns the relative amplitude, 0 .. 1, of a pulse of \a part steps in a period of \a whole
/// steps, for boards with another step count.
inline double pulseAmplitude(double part, double whole)
{
    return std::sin(kPi * part / whole);
}

} // namespace midair::base
