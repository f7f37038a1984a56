#pragma once

#include "haptics/sensation/SensationPlayer.h"

#include <optional>

namespace midair::haptics
{

/// How a device takes fields: one by one over its line, or stored and timed by itself.
struct TurnStore
{
    static constexpr double kLeastOnOff = 2.0; ///< leastOfPeriod of what is only on or off

    double carried_Hz = 0.0; ///< fields per second, one by one; 0: any number
    int fields = 0;          ///< maximum number that it stores and repeats; 0: none
    double clock_Hz = 0.0;   ///< stored fields follow each other at this over a whole number;
                             ///< 0: at any rate
    double leastOfPeriod = SensationPlayer::kLeastOfPeriod; ///< fields of a modulation's period
};

/// Fields that a device stores and repeats, so that it plays a sensation that doesn't change by
/// itself, although its line is too slow for that.
struct StoredTurn
{
    int fields = 0;       ///< until all repeats
    double rate_Hz = 0.0; ///< of fields
    int turns = 0;        ///< of the brush within them; 0: its outline is played, or it is a point
    int periods = 0;      ///< of the modulation within them; 0: it is left out, or there is none

    double draw_Hz() const { return turns * rate_Hz / fields; }         ///< as played
    double modulation_Hz() const { return periods * rate_Hz / fields; } ///< as played
    double duration_s() const { return fields / rate_Hz; }
    /// What it plays of a sensation.
    SensationCarried carried() const;
};

/// Returns the fields for a brush that turns \a draw_Hz times a second (0: a point) and a
/// modulation of \a modulation_Hz (0: none), both >= 0. None: fields one by one are fast enough, or
/// the device stores nothing that plays more of it.
///
/// Of all numbers of fields up to kMostStored it takes the one with the smallest error of the
/// frequencies, and of those the smallest number. If the device can't store brush and modulation
/// together, the modulation counts more: the brush is then played as an outline.
std::optional<StoredTurn> storedTurn(const TurnStore& store, double draw_Hz, double modulation_Hz);

constexpr int kMostStored = 256;         ///< a second or less to compute
constexpr double kMostTurnError = 0.01;  ///< of a stored frequency
constexpr double kToldTurnError = 0.001; ///< a larger one is told

} // namespace midair::haptics
