#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/probe/PressureProbe.h"

#include <vector>

namespace midair::bridge
{

/// Recent drives of a simulated array.
struct PlayedDrives
{
    std::vector<device::PlayedField> fields; ///< in order; empty: unknown to the device
    double until_s = 0.0;                    ///< steady clock, s; the last one plays until then
};

/// Returns the drives that \a device has played in the last \a duration_s (0 .. 0.1), and in the
/// few milliseconds before, whose sound was still in the air.
PlayedDrives playedOf(const device::ArrayDevice& device, double duration_s);

/// Returns the ringing of \a array, s, with a device of \a ability: the value in the URI of a
/// simulation (`sim:?ringing=190us`), else the array's own.
double simulatedRinging_s(const haptics::TransducerArray& array,
                          const device::DriveAbility& ability);

/// Returns \a played as a schedule whose time 0 is until_s. The first drive counts as playing since
/// ever. Throws InputError if the drives are unknown.
haptics::DriveSchedule scheduleOf(const PlayedDrives& played);

/// Returns options of a probe of the last \a duration_s (> 0) of \a played, with \a rate_Hz samples
/// a second.
haptics::ProbeOptions lastMoments(double duration_s, double rate_Hz);

} // namespace midair::bridge
