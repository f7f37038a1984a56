#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/IndexList.h"
#include "haptics/base/text/Quantity.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/Descriptions.h"

#include <osgMidair/HapticSettings>

#include <algorithm>
#include <array>

namespace osgMidair
{

namespace
{

/// Returns what the InputError of \a read says, or an empty text.
template<typename Read>
std::string refusalOf(const Read& read)
{
    try
    {
        read();
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

bool HapticSettings::set(const std::string& name, const std::string& value, std::string& error)
{
    const Setting<HapticSettings>* row = sceneSettings().find(name);
    if (!sceneSettings().set(*this, name, value, error))
    {
        // A limit that isn't understood can only be kept by silence.
        if (!sceneSettings().concernsSafety(name)) return false;
        isSilenced = true;
        error += "; nothing is played";
        whySilenced.push_back(error);
        return false;
    }
    if (const auto wish = wishOf(row->name))
        (wishes.*wish).reset(); // set by the user, not by a file
    return true;
}

bool HapticSettings::isLimit(double maxPressure_Pa, double maxAmplitude, double earLimit_dB)
{
    using namespace midair::base;
    const bool isForEars =
        earLimit_dB == 0.0 || (earLimit_dB >= kLeastEarLimit_dB && earLimit_dB <= kMostEarLimit_dB);
    return isForEars && maxPressure_Pa >= 0.0 && maxPressure_Pa <= kMostPressure_Pa &&
           maxAmplitude >= 0.0 && maxAmplitude <= 1.0; // also false for NaN
}

// A safety value's default isn't used: silence takes its place.
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
            // Environment::replace() may have asked before.
            if (std::find(whySilenced.begin(), whySilenced.end(), what) == whySilenced.end())
                whySilenced.push_back(what);
        }
        said.push_back(std::move(what));
    }
    // No row judges a text.
    const auto refuse = [&](const std::string& why, std::string& text)
    {
        const std::string what = why + "; nothing is played";
        isSilenced = true;
        if (std::find(whySilenced.begin(), whySilenced.end(), what) == whySilenced.end())
            whySilenced.push_back(what);
        said.push_back(what);
        text.clear();
    };
    using namespace midair::base;
    if (std::vector<std::array<double, 3>> places; !parsePlaces(earPoints, places))
        refuse("earPoints is \"" + earPoints + "\", should be " + kPlacesExpected, earPoints);
    if (const std::string why = refusalOf([&] { parseIndices(dead, "dead"); }); !why.empty())
        refuse(why, dead);
    if (const std::string why =
            refusalOf([&] { parseIndexedNumbers(weak, "weak", midair::haptics::kMostGain); });
        !why.empty())
        refuse(why, weak);
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
