#pragma once

#include "tests/benchmarks/solver/Cell.h"

#include <string>
#include <vector>

namespace midair::bench
{

/// Runs each of \a cells with this program and with \a oldBinary, the midair-bench of another
/// build, and prints how they compare. A block is a process of its own with cell.repeats solves;
/// the two builds take turns for \a rounds rounds, and who begins alternates, so that a machine
/// that slows down slows both. An older program is asked only for what it has always known; a cell
/// without a solver's name is run with each build's own default. Throws InputError if a program
/// can't be run or writes no results.
void compare(const std::vector<Cell>& cells, const std::string& oldBinary, int rounds);

} // namespace midair::bench
