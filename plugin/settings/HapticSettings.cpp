#include "haptics/base/Limits.h"
#include "plugin/settings/AllSettings.h"

#include <osgMidair/HapticSettings>

namespace osgMidair
{

bool HapticSettings::set(const std::string& name, const std::string& value, std::string& error)
{
    const Setting<HapticSettings>* row = sceneSettings().find(name);
    if (!sceneSettings().set(*this, name, value, error))
    {
        // A limit that isn't understood can only be kept by silence.
        if (!row || !row->isSafety) return false;
        isSilenced = true;
        error += "; nothing is played";
        return false;
    }
    if (const auto wish = wishOf(row->name))
        (wishes.*wish).reset(); // set by the user, not by a file
    return true;
}

bool HapticSettings::isLimit(double maxPressure_Pa, double maxAmplitude)
{
    return maxPressure_Pa >= 0.0 && maxPressure_Pa <= midair::base::kMostPressure_Pa &&
           maxAmplitude >= 0.0 && maxAmplitude <= 1.0; // also false for NaN
}

int HapticSettings::formatVersion()
{
    static const int newest = sceneSettings().newestVersion();
    return newest;
}

std::vector<std::string> HapticSettings::repair()
{
    const bool isLimited = isLimit(maxPressure, maxAmplitude);
    std::vector<std::string> said = sceneSettings().repair(*this);
    if (isLimited) return said;
    isSilenced = true;
    said.emplace_back("a limit is out of range: nothing is played");
    return said;
}

std::vector<std::pair<std::string, std::string>> HapticSettings::describe()
{
    return sceneSettings().describe();
}

bool operator==(const HapticSettings& a, const HapticSettings& b)
{
    return sceneSettings().areSame(a, b) && a.wishes == b.wishes && a.isSilenced == b.isSilenced;
}

} // namespace osgMidair
