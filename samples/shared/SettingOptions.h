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

/// For CLI::Option::transform(): takes a number in \a unit, or with another unit of the same kind:
/// "8 cm" in "m" is 0.08. Anything else is refused. \a read: reads such a text.
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

/// Names and values of settings that the command line gives.
using Given = std::vector<std::pair<std::string, std::string>>;

/// Returns the option of a setting: "maxPressure" is --max-pressure. One has an
/// older, shorter name.
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

/// Returns what the help writes for a value.
inline std::string typeOf(const std::string& unit, bool isWord)
{
    return isWord ? "WORD" : unit.empty() ? "VALUE" : unit;
}

/// Adds the option of the setting \a name, whose values go to \a given, which must outlive the
/// parsing. \a type: what the help writes for a value; a value of which \a problemOf returns what
/// is wrong, as a phrase, is refused.
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

inline constexpr char kRecorded[] = "recorded:"; ///< before the file's name in a source of hands

/// Returns the source of hands that \a text names on a command line: a recording's file, FILE.csv,
/// is one that repeats, "recorded:FILE.csv?loop"; all else stays as it is.
inline std::string handsOf(const std::string& text)
{
    const std::string ending = ".csv";
    const bool isFile = text.size() > ending.size() && text.find(':') == std::string::npos &&
                        text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
    return isFile ? kRecorded + text + "?loop" : text;
}

/// Returns true if the source of hands \a hands is a recording.
inline bool isRecording(const std::string& hands)
{
    return hands.rfind(kRecorded, 0) == 0;
}

} // namespace midair::samples
