#pragma once

#include <array>
#include <string>
#include <vector>

namespace midair::base
{

/// Splits \a text into the number that it begins with and the word that follows, without the blanks
/// around both: "1.2 kPa" and "1.2kPa" are 1.2 and "kPa". Returns false, and changes nothing, if it
/// doesn't begin with a finite number or if there is more than one word: "500,0 Pa", "1e999",
/// "nan".
bool splitQuantity(const std::string& text, double& number, std::string& unit);

/// Reads all of \a text as a number in \a unit, or with another unit of the same kind, which is
/// converted: "8 cm" in "m" is 0.08, "5 s" in "ms" is 5000. A setting without a unit is a ratio,
/// which may be given in percent. Returns false, and leaves \a value unchanged, for anything else,
/// a unit of another kind included.
bool parseQuantity(const std::string& text, const std::string& unit, double& value);

/// Returns true if \a word is a unit in which a number in \a unit may be given.
bool isUnitFor(const std::string& word, const std::string& unit);

/// The most places that one text may name.
constexpr std::size_t kMostPlacesInText = 64;

/// Reads places, "x y z; x y z .." in m, as listening places are given: "0 0 0.6; 30 0 60 cm", a
/// unit behind three numbers counting for all of them. A semicolon may follow the last; an empty
/// text names none. Returns false, and leaves \a places, for any other text ("0 0 1;; 0 0 2") and
/// for more than kMostPlacesInText.
bool parsePlaces(const std::string& text, std::vector<std::array<double, 3>>& places);

/// What parsePlaces() reads, for messages.
inline constexpr const char* kPlacesExpected = "x y z; x y z .. in m, at most 64 places";

/// Reads true, yes, on, 1 and false, no, off, 0, in capitals as well. Returns false, and leaves \a
/// value unchanged, for anything else.
bool parseYesNo(const std::string& text, bool& value);

/// Returns \a text with the letters A to Z as small ones, in every locale.
std::string lowerCase(const std::string& text);

} // namespace midair::base
