#pragma once

#include <cstdint>

namespace midair::haptics
{

/// Returns random number \a index of the sequence \a seed, uniform in 0 .. 1, without 1: SplitMix64
/// (Steele, Lea, Flood 2014), whose numbers can be had in any order.
inline double uniformDraw(std::uint64_t seed, std::uint64_t index)
{
    std::uint64_t z = seed + (index + 1) * 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1.0p-53;
}

} // namespace midair::haptics
