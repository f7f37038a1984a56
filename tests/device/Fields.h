#pragma once

#include "device/drive/DriveSignal.h"

#include <random>

/// A repeatable random field.
inline midair::device::DriveSignal randomField(int transducers, unsigned seed)
{
    std::mt19937 random(seed);
    midair::device::DriveSignal signal;
    for (int i = 0; i < transducers; ++i)
    {
        signal.phase.push_back(static_cast<std::uint8_t>(random()));
        signal.duty.push_back(static_cast<std::uint8_t>(random()));
    }
    return signal;
}

/// All transducers alike.
inline midair::device::DriveSignal evenField(int transducers, std::uint8_t phase, std::uint8_t duty)
{
    midair::device::DriveSignal signal;
    signal.phase.assign(transducers, phase);
    signal.duty.assign(transducers, duty);
    return signal;
}

namespace midair::device
{

inline bool operator==(const DriveSignal& a, const DriveSignal& b)
{
    return a.phase == b.phase && a.duty == b.duty;
}

} // namespace midair::device
