#pragma once

namespace midair::samples
{

/// From now on this program opens `sim:?board=autd3` as well: AUTD3 units that are emulated in it.
void registerEmulatedDevices();

} // namespace midair::samples
