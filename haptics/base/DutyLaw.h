#pragma once

#include "haptics/base/Units.h"

#include <cmath>

namespace midair::base
{

/// A transducer is driven by a pulse a period of the ultrasound, and sounds with the pulse's
/// fundamental: a pulse of a share d of the period, 0 .. 1/2, drives with the relative amplitude
/// sin(pi d), 0 .. 1. Duty levels count shares in 1/510, so that level 255, the most that a byte
/// holds, is half a period: full drive.
constexpr int kDutyPeriod = 510;
constexpr int kFullDuty = 255;

/// The relative amplitude, 0 .. 1, of duty level \a level, 0 .. kFullDuty; also between two levels.
inline double dutyAmplitude(double level)
{
    return std::sin(kPi * level / kDutyPeriod);
}

/// The duty level, 0 .. kFullDuty and not rounded, of a relative amplitude of 0 .. 1.
inline double dutyLevel(double amplitude)
{
    return kDutyPeriod / kPi * std::asin(amplitude);
}

/// The relative amplitude, 0 .. 1, of a pulse of \a part of a period of \a whole, for boards that
/// count in steps of their own.
inline double pulseAmplitude(double part, double whole)
{
    return std::sin(kPi * part / whole);
}

} // namespace midair::base
