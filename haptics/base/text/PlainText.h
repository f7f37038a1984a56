#pragma once

#include <sstream>
#include <string>

namespace midair::base
{

/// Formats like printf; numbers have a decimal point whatever the locale of the thread or the
/// program.
std::string plainText(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

/// String stream whose numbers have a decimal point and no thousands separators in every locale.
class PlainStream : public std::ostringstream
{
public:
    PlainStream() { imbue(std::locale::classic()); }
};

} // namespace midair::base
