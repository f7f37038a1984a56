#pragma once

namespace midair::bench
{

/// Prints what reading a mesh costs the update thread: one that is new, one of which everything is
/// said to be new, one whose vertices move with dirty() and without, and ten that come at once.
void printReading();

} // namespace midair::bench
