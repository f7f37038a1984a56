#pragma once

#include <sstream>
#include <string>

namespace midair::base
{

/// printf into a text; its numbers have a point whatever the locale, of the thread or of the
/// program.
std::string plainText(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

/// A text that is put together with <<; its numbers have a point, and nothing between the
/// thousands, whatever the locale.
class PlainStream : public std::ostringstream
{
public:
    PlainStream() { imbue(std::locale::classic()); }
};

} // namespace midair::base
