#pragma once

namespace midair::bench
{

/// Prints what update() costs a program's own loop: where 200 and \a objects new balls come at
/// once, where as many stand still, move or rest; and the processor time of all threads up to the
/// first field where surfaces share a drawable.
void printFrames(int objects);

} // namespace midair::bench
