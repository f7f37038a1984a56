#pragma once

namespace midair::bench
{

/// Prints how far a ball at 0.3 m/s over one board is played from where it is seen, by what was
/// handed to the device and when, against the ball's known way and the frame's light.
void printSeenAndPlayed(double seconds);

} // namespace midair::bench
