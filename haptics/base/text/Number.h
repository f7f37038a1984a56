#pragma once

#include <string>

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

} // namespace midair::base
