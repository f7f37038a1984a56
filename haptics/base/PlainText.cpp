#include "haptics/base/PlainText.h"

#include "haptics/base/Number.h"

#include <cstdarg>
#include <cstdio>
#include <vector>

namespace midair::base
{

std::string plainText(const char* pattern, ...)
{
    const DecimalPoint point;
    std::vector<char> text(256);
    va_list values;
    va_list again;
    va_start(values, pattern);
    va_copy(again, values);
    const int length = std::vsnprintf(text.data(), text.size(), pattern, values);
    va_end(values);
    if (length >= static_cast<int>(text.size()))
    {
        text.resize(static_cast<std::size_t>(length) + 1);
        std::vsnprintf(text.data(), text.size(), pattern, again);
    }
    va_end(again);
    return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : std::string();
}

} // namespace midair::base
