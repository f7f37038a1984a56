#include "haptics/base/text/Quantity.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"

#include <osgMidair/HapticSettings>

#include <algorithm>

namespace osgMidair
{

bool HapticSettings::set(const std::string& name, const std::string& value, std::string& error)
{
    const Setting<HapticSettings>* row = sceneSettings().find(name);
    if (!sceneSettings().set(*this, name, value, error))
    {
        // An invalid limit can only be kept by silence.
        if (!sceneSettings().concernsSafety(name)) return false;
        silence(*this, error += "; nothing is played");
        return false;
    }
    wishes.asked.erase(row->name); // set by the user, not by a file
    return true;
}

bool HapticSettings::isLimit(double maxPressure_Pa, double maxAmplitude, double earLimit_dB)
{
    HapticSettings asked;
    asked.maxPressure = maxPressure_Pa;
    asked.maxAmplitude = maxAmplitude;
    asked.earLimit = earLimit_dB;
    const auto& rows = sceneSettings().rows();
    return std::all_of(rows.begin(), rows.end(), [&](const auto& row) { return row.holds(asked); });
}

// An invalid safety value isn't replaced by its default but silences.
std::vector<std::string> HapticSettings::repair()
{
    std::vector<std::string> said;
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
    {
        std::string what;
        if (!row.repair(*this, what)) continue;
        if (row.isSafety)
        {
            isSilenced = true;
            what = what.substr(0, what.rfind("; ")) + "; nothing is played";
            // Environment::replace() may have added it before.
            if (std::find(whySilenced.begin(), whySilenced.end(), what) == whySilenced.end())
                whySilenced.push_back(what);
        }
        said.push_back(std::move(what));
    }
    return said;
}

std::vector<std::pair<std::string, std::string>> HapticSettings::describe()
{
    return sceneSettings().describe();
}

std::vector<SettingDescription> HapticSettings::getDescriptions()
{
    return descriptionsOf(sceneSettings());
}

std::string HapticSettings::problemOf(const std::string& name, const std::string& value)
{
    return osgMidair::problemOf(sceneSettings(), name, value);
}

bool readQuantity(const std::string& text, const std::string& unit, double& value)
{
    return midair::base::parseQuantity(text, unit, value);
}

bool operator==(const HapticSettings& a, const HapticSettings& b)
{
    return sceneSettings().areSame(a, b) && a.arrayDescription == b.arrayDescription &&
           a.wishes == b.wishes && a.isSilenced == b.isSilenced && a.whySilenced == b.whySilenced;
}

} // namespace osgMidair
