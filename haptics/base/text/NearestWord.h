#pragma once

#include <string>
#include <vector>

namespace midair::base
{

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
