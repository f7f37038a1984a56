#pragma once

#include <string>
#include <utility>
#include <vector>

namespace midair::base
{

/// Largest index that lists of transducers may name: arrays have at most 65536.
constexpr int kMostIndex = 65535;

/// Reads numbers from 0 and ranges of them, "17, 400-410", both ends included; empty: none. Returns
/// them ascending. Throws InputError, which begins with \a what, for anything else, for a number
/// above kMostIndex, and for one that is there twice.
std::vector<int> parseIndices(const std::string& text, const std::string& what);

/// Reads the same with a number for each entry, "17:0.5, 400-410:0.8", above 0 and at most
/// \a most. Returns them ascending by index. Throws InputError likewise.
std::vector<std::pair<int, double>>
parseIndexedNumbers(const std::string& text, const std::string& what, double most);

} // namespace midair::base
