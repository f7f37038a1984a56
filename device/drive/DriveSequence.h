#pragma once

#include "device/drive/DriveSignal.h"

#include <vector>

namespace midair::device
{

/// Fields that a device stores and times by itself. It repeats them, starting with the first, until
/// the next send(), sendSequence() or silence().
struct DriveSequence
{
    static constexpr double kMostRate_Hz = 40e3; ///< one field per period of the ultrasound

    std::vector<DriveSignal> signals; ///< at least one; all of one length
    double rate_Hz = 1000.0;          ///< over 0, at most kMostRate_Hz; fields per second

    /// Returns true if there are signals, each for \a transducers, and the rate is in its range.
    bool fits(int transducers) const;
};

} // namespace midair::device
