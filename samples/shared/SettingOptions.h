#pragma once

#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// Returns a validator for CLI::Option::transform() that converts a number with a unit, e.g. "8 cm"
/// to 0.08 for \a unit "m". A number without a unit is in \a unit. \a read parses the text.
inline CLI::Validator inUnit(const std::string& unit,
                             bool (*read)(const std::string&, const std::string&, double&))
{
    const auto convert = [unit, read](std::string& text) -> std::string
    {
        double value = 0.0;
        if (!read(text, unit, value))
            return "is \"" + text + "\", should be a number" + (unit.empty() ? "" : " in " + unit);
        std::array<char, 32> digits{};
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
        text.assign(digits.data(), end.ptr);
        return {};
    };
    return {convert, ""};
}

/// Names and values of the settings on the command line.
using Given = std::vector<std::pair<std::string, std::string>>;

/// Returns the option of a setting: "maxPressure" is --max-pressure. modulationFrequency has the
/// short form --modulation as well.
inline std::string optionName(const std::string& setting)
{
    std::string name = "--";
    for (const char c : setting)
    {
        if (std::isupper(static_cast<unsigned char>(c))) name += '-';
        name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    if (setting == "modulationFrequency") name += ",--modulation";
    return name;
}

/// Returns the placeholder for a value in --help.
inline std::string typeOf(const std::string& unit, bool isWord)
{
    return isWord ? "WORD" : unit.empty() ? "VALUE" : unit;
}

/// Adds the option of the setting \a name. Its values are appended to \a given, which must outlive
/// the parsing. \a type is the placeholder in --help. \a problemOf returns what is wrong with a
/// value, or an empty string.
inline CLI::Option* addSetting(CLI::App& app,
                               const std::string& name,
                               const std::string& summary,
                               const std::string& type,
                               bool isFlag,
                               std::function<std::string(const std::string&)> problemOf,
                               Given& given)
{
    const std::string option = optionName(name);
    if (isFlag)
        return app.add_flag_function(
            option + ",--no-" + option.substr(2) + "{false}",
            [&given, name](std::int64_t count)
            { given.emplace_back(name, count > 0 ? "true" : "false"); },
            summary);
    return app
        .add_option_function<std::string>(
            option,
            [&given, name](const std::string& text) { given.emplace_back(name, text); },
            summary)
        ->type_name(type)
        ->check(CLI::Validator(std::move(problemOf), ""));
}

inline constexpr char kRecorded[] = "recorded:"; ///< prefix of a recording in a hand source

/// Returns the hand source for \a text on a command line: FILE.csv becomes
/// "recorded:FILE.csv?loop", other texts stay unchanged.
inline std::string handsOf(const std::string& text)
{
    const std::string ending = ".csv";
    const bool isFile = text.size() > ending.size() && text.find(':') == std::string::npos &&
                        text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
    return isFile ? kRecorded + text + "?loop" : text;
}

/// Returns true if the hand source \a hands is a recording.
inline bool isRecording(const std::string& hands)
{
    return hands.rfind(kRecorded, 0) == 0;
}

} // namespace midair::samples
