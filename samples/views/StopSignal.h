#pragma once

namespace midair::samples
{

/// From now on Ctrl-C (SIGINT) and SIGTERM ask the program to end after its frame, so that the
/// array falls silent and reports are written. The second one ends it at once, as without this.
void catchStopSignals();

/// Returns true once one of them came.
bool isStopAsked();

} // namespace midair::samples
