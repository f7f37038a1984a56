#pragma once

#include <algorithm>
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

/// A setting as an option of the command line.
struct SettingOption
{
    std::string name;    ///< of the setting: "maxPressure"
    std::string summary; ///< help, values and default
    std::string type;    ///< what is written for the value in the help: its unit, WORD or VALUE
    bool isFlag = false;
    /// Returns what is wrong with a value, as a phrase; empty: nothing.
    std::function<std::string(const std::string&)> problemOf;
};

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

/// Adds an option for each of \a settings except \a without; their values go to \a given, which
/// must outlive the parsing. Values that aren't understood or are out of range are refused.
inline void addSettings(CLI::App& app,
                        const std::vector<SettingOption>& settings,
                        const char* group,
                        const std::vector<std::string>& without,
                        Given& given)
{
    for (const SettingOption& setting : settings)
    {
        if (std::count(without.begin(), without.end(), setting.name) > 0) continue;
        const std::string option = optionName(setting.name);
        if (setting.isFlag)
            app.add_flag_function(
                   option + ",--no-" + option.substr(2) + "{false}",
                   [&given, name = setting.name](std::int64_t count)
                   { given.emplace_back(name, count > 0 ? "true" : "false"); },
                   setting.summary)
                ->group(group);
        else
            app.add_option_function<std::string>(
                   option,
                   [&given, name = setting.name](const std::string& text)
                   { given.emplace_back(name, text); },
                   setting.summary)
                ->type_name(setting.type)
                ->check(CLI::Validator(setting.problemOf, ""))
                ->group(group);
    }
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
