#include "haptics/base/text/Quantity.h"

#include "haptics/base/Units.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

namespace midair::base
{

namespace
{

/// Kind of quantity. Numbers of different kinds can't be converted into each other.
enum class Kind
{
    LENGTH,
    PRESSURE,
    TIME,
    FREQUENCY,
    ANGLE,
    TEMPERATURE,
    WAVELENGTHS,
    RATIO
};

struct Unit
{
    const char* name;
    Kind kind;
    double factor; ///< one of this unit in the SI unit of its kind, degrees for angles
};

// Case matters, as in SI: mPa and MPa differ.
const Unit kUnits[] = {{"m", Kind::LENGTH, 1.0},
                       {"cm", Kind::LENGTH, 1e-2},
                       {"mm", Kind::LENGTH, 1e-3},
                       {"um", Kind::LENGTH, 1e-6},
                       {"Pa", Kind::PRESSURE, 1.0},
                       {"hPa", Kind::PRESSURE, 1e2},
                       {"kPa", Kind::PRESSURE, 1e3},
                       {"s", Kind::TIME, 1.0},
                       {"ms", Kind::TIME, 1e-3},
                       {"us", Kind::TIME, 1e-6},
                       {"Hz", Kind::FREQUENCY, 1.0},
                       {"kHz", Kind::FREQUENCY, 1e3},
                       {"deg", Kind::ANGLE, 1.0},
                       {"\u00b0", Kind::ANGLE, 1.0},
                       {"rad", Kind::ANGLE, 180.0 / kPi},
                       {"C", Kind::TEMPERATURE, 1.0},
                       {"\u00b0C", Kind::TEMPERATURE, 1.0},
                       {"wavelengths", Kind::WAVELENGTHS, 1.0},
                       {"", Kind::RATIO, 1.0},
                       {"%", Kind::RATIO, 1e-2}};

const Unit* findUnit(const std::string& name)
{
    const auto* const found = std::find_if(
        std::begin(kUnits), std::end(kUnits), [&](const Unit& unit) { return unit.name == name; });
    return found == std::end(kUnits) ? nullptr : found;
}

/// Reads "30 0 60 cm".
bool parsePlace(const std::string& text, std::array<double, 3>& place)
{
    std::istringstream words(text);
    std::vector<std::string> parts;
    for (std::string part; words >> part;)
        parts.push_back(part);
    if (parts.size() != 3 && parts.size() != 4) return false;
    const std::string unit = parts.size() == 4 ? parts[3] : "";
    if (!unit.empty() && !isUnitFor(unit, "m")) return false;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!parseQuantity(parts[axis] + unit, "m", place[axis])) return false;
    return true;
}

} // namespace

bool splitQuantity(const std::string& text, double& number, std::string& unit)
{
    const std::string bare = trimmed(text);
    const char* begin = bare.data();
    const char* const end = begin + bare.size();
    if (begin != end && *begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;
    double read = 0.0;
    const auto [rest, error] = std::from_chars(begin, end, read);
    if (error != std::errc() || !std::isfinite(read)) return false;
    const std::string word = trimmed(std::string(rest, end));
    // A continuation of a number, such as a decimal comma or hexadecimal digits, is not a unit.
    if (word.find_first_of(" \t\r\n,.+-0123456789") != std::string::npos) return false;
    number = read;
    unit = word;
    return true;
}

bool isUnitFor(const std::string& word, const std::string& unit)
{
    const Unit* given = word.empty() ? nullptr : findUnit(word);
    const Unit* wanted = findUnit(unit);
    return given && wanted && given->kind == wanted->kind;
}

bool parseQuantity(const std::string& text, const std::string& unit, double& value)
{
    double number = 0.0;
    std::string word;
    if (!splitQuantity(text, number, word)) return false;
    if (!word.empty() && word != unit)
    {
        if (!isUnitFor(word, unit)) return false;
        const double given = findUnit(word)->factor;
        const double wanted = findUnit(unit)->factor;
        // Dividing by a whole number gives the double nearest to the decimal value.
        number = given < wanted ? number / std::round(wanted / given) : number * (given / wanted);
        if (!std::isfinite(number)) return false;
    }
    value = number;
    return true;
}

bool parsePlaces(const std::string& text, std::vector<std::array<double, 3>>& places)
{
    std::vector<std::array<double, 3>> read;
    std::istringstream in(text);
    for (std::string one; std::getline(in, one, ';');)
    {
        if (trimmed(one).empty() && in.eof()) break;
        if (read.size() == kMostPlacesInText || !parsePlace(one, read.emplace_back())) return false;
    }
    places = std::move(read);
    return true;
}

std::string lowerCase(const std::string& text)
{
    std::string small = text;
    for (char& c : small)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return small;
}

bool parseYesNo(const std::string& text, bool& value)
{
    const std::string word = lowerCase(trimmed(text));
    const bool yes = word == "true" || word == "yes" || word == "on" || word == "1";
    const bool no = word == "false" || word == "no" || word == "off" || word == "0";
    if (yes || no) value = yes;
    return yes || no;
}

} // namespace midair::base
