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

/// Splits \a text at each \a separator; parts may be empty, and an empty text is one part.
std::vector<std::string> splitAt(const std::string& text, char separator);

/// Splits a line at commas, semicolons, tabs and blanks. Returns no fields for a blank line or a #
/// comment.
std::vector<std::string> splitColumns(const std::string& line);

/// Returns \a text, which may come from a file or another program, for printing: control
/// characters, which a terminal would obey, and characters that hide text or turn its direction are
/// replaced, and it is cut after \a most bytes.
std::string printable(const std::string& text, std::size_t most = 300);

/// Returns how many letters have to be put in, left out, replaced or swapped with their neighbour
/// to make \a b of \a a, upper and lower case alike (Damerau and Levenshtein).
int editDistance(const std::string& a, const std::string& b);

/// Returns those of \a known that \a word may be a slip of the pen for, the nearest alone, or
/// several that are equally near; none if all of them differ by more than a third of their letters.
std::vector<std::string> nearestWords(const std::string& word,
                                      const std::vector<std::string>& known);

/// Returns " (did you mean X?)" with the nearest of \a known; empty if there is none.
std::string didYouMean(const std::string& word, const std::vector<std::string>& known);

} // namespace midair::base
