#pragma once

namespace midair::bench
{

/// Prints what haptics add to the processor time of a frame's own thread, without drawing and in a
/// headset of the tests' runtime; and that no frame waits for a solver of 50 ms.
void printFrameCost(int rounds);

} // namespace midair::bench
