#pragma once

#include <string>

namespace midair::bench
{

/// How sensations play in a simulated octagon, in real time.
struct PlayedFigures
{
    double fields_Hz = 0.0; ///< played
    double skipped = 0.0;   ///< share of the fields that a clock of their rate would have had
    double late_ms[2] = {}; ///< median and 99th percentile: from a sample's time to its play
    /// share of a processor's core, with the device, for all fields of that clock: those that were
    /// skipped cost as much as the others
    double core = 0.0;
    double away_mm[2] = {};      ///< rms and largest distance of the field's focus from its sample
    double frequency_Hz = 0.0;   ///< of the turns of the brush
    double mostJump_turns = 0.0; ///< largest difference of a turn from that frequency
};

/// Plays \a sensations circles of 20 mm at 70 turns a second for \a duration_s, at 1,000 fields a
/// second, on \a device.
PlayedFigures playCircles(int sensations, const std::string& device, double duration_s);

/// Wakes 1,000 times a second for \a duration_s, and does nothing: what this machine makes of it.
PlayedFigures wakeOnly(double duration_s);

} // namespace midair::bench
