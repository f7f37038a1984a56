#pragma once

#include "device/drive/DriveSignal.h"

#include <vector>

namespace midair::device
{

/// Fields that a device keeps and times by itself: played over and over, from the first, until the
/// next send(), sendSequence() or silence().
struct DriveSequence
{
    static constexpr double kMostRate_Hz = 40e3; ///< a field a period of the ultrasound

    std::vector<DriveSignal> signals; ///< at least one; all of one length
    double rate_Hz = 1000.0;          ///< > 0 .. kMostRate_Hz; fields a second

    /// Whether it is one for \a transducers: signals are there, each of that length, and the rate
    /// is in its range.
    bool fits(int transducers) const;
};

} // namespace midair::device
