#pragma once

#include "haptics/base/simd/Kernel.h"

#include <cstdint>

/// DriveEncoder's loops over transducers, compiled for several instruction sets and selected at run
/// time.
namespace midair::device
{

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
/// Computes the phase and duty levels of m activations, given as alternating real and imaginary
/// parts, all finite: the levels nearest to the phase and to the amplitude (clipped at 1). Within
/// 1e-4 of a phase level, or 1e-2 of an amplitude level, of the middle between two levels either
/// may result. An amplitude below 1e-37 may get any phase.
extern const base::Kernel<void(const float* q, int m, std::uint8_t* phase, std::uint8_t* duty)>
    encodeLevels;

/// Returns true if none of \a count values is infinite or NaN.
extern const base::Kernel<bool(const float* values, int count)> allFinite;

/// Raises \a peak to the largest of \a m duty levels, and adds all of them to \a sum.
extern const base::Kernel<void(const std::uint8_t* duty, int m, int* peak, std::uint32_t* sum)>
    addDuties;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::device
