#pragma once

namespace midair::device
{

/// Lets this program open `sim:?board=autd3`: the driver of `autd3:` with its parameters, on
/// emulated units with their faults. played() is their output.
void registerRehearsedAutd3();

} // namespace midair::device
