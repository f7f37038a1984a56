#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/TransducerArray.h"

#include <memory>
#include <string>

namespace midair::bridge
{

/// Opens a device for output without a scene (patterns, plans, recordings) within the stricter of
/// the caps of the user's environment, device::capsOfUser(), and \a limits. An ear limit applies to
/// every field: its amplitudes are lowered until it keeps the limit around the array and at the
/// user's listening places; a field of which nothing remains is refused and silence is played
/// instead. A pressure cap is in ability(), for callers that know the control points.
///
/// \a array: the device's array, with as many transducers as \a layout; null: unknown. Throws
/// DeviceError if the device can't be opened, if a cap is invalid, and if there is an ear limit
/// that can't be enforced: without an array, and for devices that play by themselves.
std::unique_ptr<device::ArrayDevice> openForUser(const std::string& uri,
                                                 const device::DeviceLayout& layout,
                                                 const haptics::TransducerArray* array,
                                                 const device::SafetyLimits& limits = {},
                                                 const std::string& owner = {});

} // namespace midair::bridge
