#pragma once

#include <array>
#include <string>
#include <vector>

namespace midair::base
{

/// Splits \a text into its leading number and the following word, without surrounding blanks: "1.2
/// kPa" and "1.2kPa" give 1.2 and "kPa". Returns false, and changes nothing, if it doesn't begin
/// with a finite number or has more than one word: "500,0 Pa", "1e999", "nan".
bool splitQuantity(const std::string& text, double& number, std::string& unit);

/// Parses all of \a text as a number in \a unit, or in another unit of the same kind, which is
/// converted: "8 cm" in "m" is 0.08, "5 s" in "ms" is 5000. A setting without a unit is a ratio,
/// which also accepts percent. Returns false, and leaves \a value unchanged, for anything else,
/// including units of another kind.
bool parseQuantity(const std::string& text, const std::string& unit, double& value);

/// Returns true if \a word is a unit that converts to \a unit.
bool isUnitFor(const std::string& word, const std::string& unit);

/// Maximum number of places in one text.
constexpr std::size_t kMostPlacesInText = 64;

/// Parses listening places, "x y z; x y z .." in m: "0 0 0.6; 30 0 60 cm"; a unit after three
/// numbers applies to all of them. A semicolon may follow the last; an empty text has no places.
/// Returns false, and leaves \a places, for other texts ("0 0 1;; 0 0 2") and for more than
/// kMostPlacesInText.
bool parsePlaces(const std::string& text, std::vector<std::array<double, 3>>& places);

/// Input of parsePlaces(), for messages.
inline constexpr const char* kPlacesExpected = "x y z; x y z .. in m, at most 64 places";

/// Parses true, yes, on, 1 and false, no, off, 0, in upper case as well. Returns false, and leaves
/// \a value unchanged, for anything else.
bool parseYesNo(const std::string& text, bool& value);

/// Returns \a text with A to Z in lower case, in every locale.
std::string lowerCase(const std::string& text);

} // namespace midair::base
