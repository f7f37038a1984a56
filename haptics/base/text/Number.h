#pragma once

#include <string>

namespace midair::base
{

/// Reads the whole of \a text as a finite decimal number, "-1.5e3", with a point whatever the
/// locale; false, and \a value untouched, for anything else: blanks, a comma, hexadecimal, nan,
/// inf, and what a double can't hold.
bool parseNumber(const std::string& text, double& value);

/// The same for a whole number within an int.
bool parseWhole(const std::string& text, int& value);

/// "0.2", "1e-05": at most six digits, with a point whatever the locale.
std::string shortNumber(double value);

} // namespace midair::base
