#pragma once

namespace midair::bench
{

/// Prints fields per second and errors of ManyFields beside published figures, on \a threads
/// threads; each number is the best of \a repeats runs.
void printMany(int threads, int repeats);

} // namespace midair::bench
