#pragma once

#include "device/autd3/Autd3Options.h"
#include "device/autd3/DatagramLink.h"
#include "device/autd3/Refusals.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// "autd3", with the interface or group where one is named: what messages call the device.
std::string deviceName(const Autd3Options& options);

/// Opens the way to the units that \a options name: by their group, by their interface, or by the
/// one interface that units answer on. Throws DeviceError, which names the interfaces that were
/// tried or that have answers, also as soon as \a isLeft returns true.
std::unique_ptr<DatagramLink>
chooseLink(const Autd3Options& options, Refusals& refusals, const std::function<bool()>& isLeft);

/// Units that answer on an interface.
struct UnitsListing
{
    std::string interface;
    int units = 0;        ///< at least 1; those behind a way that is closed don't answer
    std::string firmware; ///< of one of them; empty: it speaks another protocol
};

/// Asks on all interfaces, 0.1 s each and up to three times; changes nothing at the units.
std::vector<UnitsListing> listUnits();

} // namespace midair::device::autd3
