#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/probe/PressureProbe.h"

#include <vector>

namespace midair::bridge
{

/// What a simulated array has played of late, and until when.
struct PlayedDrives
{
    std::vector<device::PlayedField> fields; ///< in order; empty: the device doesn't know
    double until_s = 0.0;                    ///< steady clock, s; the last one plays until then
};

/// Returns what \a device has played in the last \a duration_s (0 .. 0.1) and in the few
/// milliseconds before in which what is heard then was under way.
PlayedDrives playedOf(const device::ArrayDevice& device, double duration_s);

/// Returns the ringing of \a array, s, as a device of \a ability has it: what the URI of a
/// simulation asks for (`sim:?ringing=190us`), else the array's own.
double simulatedRinging_s(const haptics::TransducerArray& array,
                          const device::DriveAbility& ability);

/// Returns \a played as a schedule, in which time 0 is until_s. What sounded first counts as having
/// sounded since ever. Throws InputError where nothing is known.
haptics::DriveSchedule scheduleOf(const PlayedDrives& played);

/// Returns when a probe of \a played looks at its last \a duration_s (> 0), \a rate_Hz samples a
/// second.
haptics::ProbeOptions lastMoments(double duration_s, double rate_Hz);

} // namespace midair::bridge
