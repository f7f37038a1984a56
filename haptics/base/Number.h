#pragma once

#include <string>

#include <locale.h> // NOLINT(modernize-deprecated-headers): locale_t is POSIX's

namespace midair::base
{

/// Reads the whole of \a text as a finite decimal number, "-1.5e3", with a point whatever the locale; false, and \a value
/// untouched, for anything else: blanks, a comma, hexadecimal, nan, inf, and what a double can't hold.
bool parseNumber(const std::string& text, double& value);

/// The same for a whole number within an int.
bool parseWhole(const std::string& text, int& value);

/// "0.2", "1e-05": at most six digits, with a point whatever the locale.
std::string shortNumber(double value);

/// As long as it lives, this thread's printf() and its like write numbers with a point, whatever the locale.
class DecimalPoint
{
public:
    DecimalPoint();
    ~DecimalPoint();
    DecimalPoint(const DecimalPoint&) = delete;
    DecimalPoint& operator=(const DecimalPoint&) = delete;

private:
    const locale_t _before;
};

} // namespace midair::base
