#include "samples/shared/views/EmulatedDevices.h"

#include "device/autd3/emulator/RehearsedAutd3.h"

namespace midair::samples
{

void registerEmulatedDevices()
{
    device::registerRehearsedAutd3();
}

} // namespace midair::samples
