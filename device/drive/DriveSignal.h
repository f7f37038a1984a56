#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace midair::device
{

/// One field in hardware levels: phase level L means e^{+j 2 pi L/256}; duty level L means a pulse
/// of L/510 of the period, with the relative amplitude base::dutyAmplitude(L). Both m long.
struct DriveSignal
{
    std::vector<std::uint8_t> phase;
    std::vector<std::uint8_t> duty;

    int size() const { return static_cast<int>(phase.size()); }
    /// Returns true if it has a phase and a duty for each of \a transducers.
    bool fits(int transducers) const
    {
        return size() == transducers && duty.size() == phase.size();
    }
};

/// Returns the signal that turns all of \a transducers off.
inline DriveSignal silentSignal(int transducers)
{
    const auto m = static_cast<std::size_t>(transducers);
    return {std::vector<std::uint8_t>(m, 0), std::vector<std::uint8_t>(m, 0)};
}

/// Fields that a device stores and times itself. It repeats them, starting with the first, until
/// the next send(), sendSequence() or silence().
struct DriveSequence
{
    static constexpr double kMostRate_Hz = 40e3; ///< one field per period of the ultrasound

    std::vector<DriveSignal> signals; ///< at least one; all of one length
    double rate_Hz = 1000.0;          ///< over 0, at most kMostRate_Hz; fields per second

    /// Returns true if there are signals, each for \a transducers, and the rate is in its range.
    bool fits(int transducers) const
    {
        return !signals.empty() && rate_Hz > 0.0 && rate_Hz <= kMostRate_Hz &&
               std::all_of(signals.begin(),
                           signals.end(),
                           [&](const DriveSignal& signal) { return signal.fits(transducers); });
    }
};

} // namespace midair::device
