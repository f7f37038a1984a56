#pragma once

#include "tests/benchmarks/solver/Cell.h"

#include <vector>

namespace midair::bench
{

/// Runs each of \a cells in free air, above a plane without end and above a table of 600 mm, 200 mm
/// below the middle, in turn for \a rounds rounds, and prints what updates cost and how they err.
void printReflected(const std::vector<Cell>& cells, int rounds);

} // namespace midair::bench
