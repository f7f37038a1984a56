#pragma once

#include <string>
#include <vector>

namespace midair::base
{

/// Returns \a text without leading and trailing blanks (spaces, tabs, line ends).
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

/// Returns \a text, which may come from a file or another program, in printable form: replaces
/// control characters, which a terminal would obey, and characters that hide text or change its
/// direction; cuts it after \a most bytes.
std::string printable(const std::string& text, std::size_t most = 300);

/// Returns the number of insertions, deletions, replacements and swaps of neighbouring letters that
/// turn \a a into \a b, ignoring case (Damerau and Levenshtein).
int editDistance(const std::string& a, const std::string& b);

/// Returns the words of \a known that \a word may be a misspelling of: the nearest, or several at
/// the same distance; none if all differ by more than a third of their letters.
std::vector<std::string> nearestWords(const std::string& word,
                                      const std::vector<std::string>& known);

/// Returns " (did you mean X?)" with the nearest of \a known; empty if there is none.
std::string didYouMean(const std::string& word, const std::vector<std::string>& known);

} // namespace midair::base
