// Replaces this folder in builds without AUTD3: opening units throws an error.

#include "device/DeviceUri.h"
#include "device/autd3/Autd3Device.h"

namespace midair::device
{

std::unique_ptr<ArrayDevice> openAutd3(DeviceUri& uri, const DeviceLayout&)
{
    throw uri.error("AUTD3 is not in this build; configure it with -DMIDAIR_AUTD3=ON");
}

} // namespace midair::device
