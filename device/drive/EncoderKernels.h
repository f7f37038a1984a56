#pragma once

#include "haptics/base/simd/Kernel.h"

#include <cstdint>

/// The loops over transducers of DriveEncoder, compiled for every instruction set and chosen at run
/// time.
namespace midair::device
{

/// Phase and duty levels of m activations, real and imaginary parts in turn, all finite: the levels
/// nearest to the phase and to the amplitude (over 1: 1). Half-way between two levels, to 1e-4 of a
/// level of phase and 1e-2 of a level of amplitude, it may be either. An amplitude below 1e-37 has
/// any phase.
extern const base::Kernel<void(const float* q, int m, std::uint8_t* phase, std::uint8_t* duty)>
    encodeLevels;

/// True if none of \a count values is infinite or not a number.
extern const base::Kernel<bool(const float* values, int count)> allFinite;

} // namespace midair::device
