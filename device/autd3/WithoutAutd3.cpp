// In the place of this folder where AUTD3 units are left out: whoever would open them is told so.

#include "device/DeviceUri.h"
#include "device/autd3/Autd3Device.h"

namespace midair::device
{

std::unique_ptr<ArrayDevice> openAutd3(DeviceUri& uri, const DeviceLayout&)
{
    throw uri.error("AUTD3 is not in this build; configure it with -DMIDAIR_AUTD3=ON");
}

} // namespace midair::device
