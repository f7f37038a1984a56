#pragma once

namespace midair::device
{

/// Lets this program open `sim:?board=autd3`: the driver of `autd3:` with its parameters, on units
/// that are emulated in the program, with their faults. played() is what those put out.
void registerRehearsedAutd3();

} // namespace midair::device
