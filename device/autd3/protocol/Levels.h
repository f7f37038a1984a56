#pragma once

#include "device/autd3/protocol/Commands.h"
#include "device/drive/DriveSignal.h"

#include <array>
#include <cstdint>

namespace midair::device::autd3
{

/// Widths in 1/512 of the period, with which intensity D plays our duty level D: a pulse of D/510.
std::array<std::uint16_t, 256> dutyWidths();

/// Sets \a pattern to the transducers \a first .. \a first + 248 of \a signal, in the unit's levels
/// with dutyWidths(): a unit takes a phase as a delay, ours is an advance. A transducer that is off
/// keeps phase 0, so that patterns which sound the same are the same.
void toUnit(const DriveSignal& signal, int first, UnitPattern& pattern);

} // namespace midair::device::autd3
