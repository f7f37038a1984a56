#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/TransducerArray.h"

#include <memory>
#include <string>

namespace midair::bridge
{

/// Opens a device for what plays without a scene (patterns, plans, recordings) within the caps of
/// the user's environment, device::capsOfUser(), and within \a limits, the stricter of each. An ear
/// limit holds for every field that is sent: all its amplitudes are lowered until it keeps to the
/// limit around the array and at the user's listening places, and a field of which nothing is left
/// is refused, with silence in its place. A cap of pressure is in ability(), for who knows the
/// control points.
///
/// \a array: what the device plays on, of as many transducers as \a layout; null: unknown. Throws
/// DeviceError if the device can't be opened, if a cap isn't understood, and if there is an ear
/// limit that nobody can hold: without an array, and for a device that plays by itself.
std::unique_ptr<device::ArrayDevice> openForUser(const std::string& uri,
                                                 const device::DeviceLayout& layout,
                                                 const haptics::TransducerArray* array,
                                                 const device::SafetyLimits& limits = {},
                                                 const std::string& owner = {});

} // namespace midair::bridge
