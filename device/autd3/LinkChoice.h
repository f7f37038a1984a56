#pragma once

#include "device/autd3/Autd3Options.h"
#include "device/autd3/DatagramLink.h"
#include "device/autd3/Refusals.h"

#include <functional>
#include <memory>
#include <string>

namespace midair::device::autd3
{

/// "autd3", with the interface or group where one is named: what messages call the device.
std::string deviceName(const Autd3Options& options);

/// Opens the way to the units that \a options name: by their group, by their interface, or by the
/// one interface that units answer on. Throws DeviceError, which names the interfaces that were
/// tried or that have answers, also as soon as \a isLeft returns true.
std::unique_ptr<DatagramLink>
chooseLink(const Autd3Options& options, Refusals& refusals, const std::function<bool()>& isLeft);

} // namespace midair::device::autd3
