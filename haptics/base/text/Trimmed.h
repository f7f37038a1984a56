#pragma once

#include <string>

namespace midair::base
{

/// Returns \a text without the blanks (spaces, tabs, line ends) at both of its ends.
inline std::string trimmed(const std::string& text)
{
    constexpr const char* kBlanks = " \t\r\n\v\f";
    const std::size_t first = text.find_first_not_of(kBlanks);
    if (first == std::string::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

} // namespace midair::base
