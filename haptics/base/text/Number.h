#pragma once

#include <string>
#include <utility>
#include <vector>

namespace midair::base
{

/// Parses all of \a text as a finite decimal number, "-1.5e3", with a decimal point in every
/// locale. Returns false and leaves \a value unchanged for anything else: blanks, a comma,
/// hexadecimal, nan, inf, and numbers that a double can't hold.
bool parseNumber(const std::string& text, double& value);

/// Parses all of \a text as a whole number that fits an int; otherwise like parseNumber().
bool parseWhole(const std::string& text, int& value);

/// Returns the number with at most six digits and a decimal point in every locale: "0.2", "1e-05".
std::string shortNumber(double value);

/// The same, but with all its digits where six would be another number: "60", "60.0000001". For a
/// value that is compared with another one in the same sentence.
std::string exactNumber(double value);

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
