#pragma once

#include "device/ArrayDevice.h"

#include <memory>

namespace midair::device
{

class DeviceUri;

/// Opens `sim:?board=autd3`: the driver of `autd3:` with its parameters, on units that are emulated
/// in this program, with their faults. played() is what those put out. Throws DeviceError.
std::unique_ptr<ArrayDevice> openRehearsedAutd3(DeviceUri& uri, const DeviceLayout& layout);

} // namespace midair::device
