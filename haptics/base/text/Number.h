#pragma once

#include <string>
#include <utility>
#include <vector>

namespace midair::base
{

/// Parses all of \a text as a finite decimal number, "-1.5e3", with a decimal point in every
/// locale. Returns false and leaves \a value unchanged for anything else: blanks, a comma,
/// hexadecimal, nan, inf, and numbers out of a double's range.
bool parseNumber(const std::string& text, double& value);

/// Parses all of \a text as a whole number that fits an int; otherwise like parseNumber().
bool parseWhole(const std::string& text, int& value);

/// Returns the number with at most six digits and a decimal point in every locale: "0.2", "1e-05".
std::string shortNumber(double value);

/// Like shortNumber(), but with all digits if six would change the number: "60", "60.0000001". For
/// values compared with another in the same sentence.
std::string exactNumber(double value);

/// Largest index in a list of transducers: arrays have at most 65536.
constexpr int kMostIndex = 65535;

/// Parses indices and ranges, "17, 400-410", both ends included; empty: none. Returns them in
/// ascending order. Throws InputError, which begins with \a what, for syntax errors, indices above
/// kMostIndex, and duplicates.
std::vector<int> parseIndices(const std::string& text, const std::string& what);

/// Parses the same with a number for each entry, "17:0.5, 400-410:0.8", above 0 and at most \a
/// most. Returns them in ascending order. Throws InputError likewise.
std::vector<std::pair<int, double>>
parseIndexedNumbers(const std::string& text, const std::string& what, double most);

} // namespace midair::base
