#pragma once

#include <string>
#include <vector>

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

/// Splits a line at commas, semicolons, tabs and blanks. Returns no fields for a blank line or a #
/// comment.
std::vector<std::string> splitColumns(const std::string& line);

/// Returns \a text, which may come from a file or another program, for printing: control
/// characters, which a terminal would obey, and characters that hide text or turn its direction are
/// replaced, and it is cut after \a most bytes.
std::string printable(const std::string& text, std::size_t most = 300);

} // namespace midair::base
