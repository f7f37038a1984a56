#pragma once

#include "samples/shared/SettingOptions.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/SettingDescription>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// Adds --overlays and an option for each number of HapticOverlays::setNumber() except those of
/// \a without. \a words and \a numbers must outlive the parsing. \a byDefault is shown as the
/// default of --overlays.
inline void addOverlays(CLI::App& app,
                        std::vector<std::string>& words,
                        std::vector<std::pair<std::string, double>>& numbers,
                        const std::string& byDefault = "everything",
                        const std::vector<std::string>& without = {})
{
    std::vector<std::string> known;
    for (const osgMidair::OverlayDescription& overlay : osgMidair::HapticOverlays::describe())
    {
        known.push_back(overlay.word);
        for (const osgMidair::SettingDescription& number : overlay.numbers)
        {
            if (std::count(without.begin(), without.end(), number.name) > 0) continue;
            if (number.low == number.high) // it can only be switched on
            {
                app.add_flag_function(
                       optionName(number.name),
                       [&numbers, name = number.name, value = number.low](std::int64_t)
                       { numbers.emplace_back(name, value); },
                       number.help)
                    ->group("The overlays");
                continue;
            }
            app.add_option_function<double>(
                   optionName(number.name),
                   [&numbers, name = number.name](double value)
                   { numbers.emplace_back(name, value); },
                   number.help + " (" + number.values + ")")
                ->type_name(typeOf(number.unit, false))
                ->transform(inUnit(number.unit, osgMidair::readQuantity))
                ->check(CLI::Range(number.low, number.high))
                ->group("The overlays");
        }
    }
    known.emplace_back("none");
    app.add_option("--overlays", words, "Overlays to draw over the scene [" + byDefault + "]")
        ->check(CLI::IsMember(known))
        ->delimiter(',');
}

} // namespace midair::samples
