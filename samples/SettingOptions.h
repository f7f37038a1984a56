#pragma once

#include "haptics/base/settings/SettingTable.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// Names and values of settings that the command line gives.
using Given = std::vector<std::pair<std::string, std::string>>;

/// Returns the option of a setting: "maxPressure" is --max-pressure. Two have older, shorter names.
inline std::string optionName(const std::string& setting)
{
    std::string name = "--";
    for (const char c : setting)
    {
        if (std::isupper(static_cast<unsigned char>(c))) name += '-';
        name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    if (setting == "monitorInterval") name += ",--monitor";
    if (setting == "modulationFrequency") name += ",--modulation";
    return name;
}

/// Adds an option for each row of \a table except \a without; their values go to \a given, which
/// must outlive the parsing. The help names the values in \a defaults. Values that aren't
/// understood or are out of range are refused.
template<typename T>
void addSettings(CLI::App& app,
                 const base::SettingTable<T>& table,
                 const char* group,
                 const std::vector<std::string>& without,
                 Given& given,
                 const T& defaults = T())
{
    for (const base::Setting<T>& row : table.rows())
    {
        if (std::count(without.begin(), without.end(), row.name) > 0) continue;
        const std::string name = optionName(row.name);
        if (std::holds_alternative<bool T::*>(row.member))
        {
            app.add_flag_function(
                   name + ",--no-" + name.substr(2) + "{false}",
                   [&given, &row](std::int64_t count)
                   { given.emplace_back(row.name, count > 0 ? "true" : "false"); },
                   row.summary(defaults))
                ->group(group);
            continue;
        }
        const auto problem = [&row](const std::string& text) -> std::string
        {
            T scratch;
            if (row.assign(scratch, text) && row.holds(scratch)) return {};
            return "is \"" + text + "\", should be " + row.expected();
        };
        app.add_option_function<std::string>(
               name,
               [&given, &row](const std::string& text) { given.emplace_back(row.name, text); },
               row.summary(defaults))
            ->type_name(row.words.empty() ? row.unit.empty() ? "VALUE" : row.unit : "WORD")
            ->check(CLI::Validator(problem, ""))
            ->group(group);
    }
}

} // namespace midair::samples
