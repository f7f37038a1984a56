#include "haptics/base/text/Quantity.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"

#include <osgMidair/HapticProperty>

#include <atomic>
#include <set>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

std::atomic<unsigned int> changes{0};

constexpr const char* kNothing = "; nothing is played";

} // namespace

unsigned int propertyChanges()
{
    return changes;
}

void notePropertyChange()
{
    ++changes;
}

void HapticProperty::noteChange()
{
    notePropertyChange();
}

bool HapticProperty::set(const std::string& name, const std::string& value, std::string& error)
{
    if (surfaceProperties().set(*this, name, value, error)) return true;
    // An object with an invalid property must not be played louder than intended.
    if (!surfaceProperties().concernsSafety(name)) return false;
    double number = 0.0;
    std::string unit;
    if (name == "pressure" && midair::base::splitQuantity(value, number, unit) && !unit.empty())
        error += fmt::format(", with the unit Pa: {:g} Pa", number);
    error += kNothing;
    whySilenced.push_back(error);
    return false;
}

void HapticProperty::parse(const std::string& text, std::vector<std::string>& errors)
{
    // "a=1; b=2" or "a=1 b=2"; after a value with a unit ("500 Pa") a semicolon, a comma or the end
    // is required.
    std::set<std::string> seen;
    for (const auto& [name, value, line] : assignmentsIn(text))
    {
        std::string error;
        const bool isSecond = surfaceProperties().find(name) && !seen.insert(name).second;
        const bool isSafety = isSecond ? surfaceProperties().concernsSafety(name)
                                       : !name.empty() && surfaceProperties().isUnlikeAny(name);
        if (isSecond)
            error = givenTwice(name, isSafety);
        else if (set(name.empty() ? "enabled" : name, value, error))
            continue;
        else if (isSafety)
            error += kNothing;
        if (isSafety) whySilenced.push_back(error);
        errors.push_back(error);
    }
}

// An invalid pressure might be any, so it silences.
std::vector<std::string> HapticProperty::repair()
{
    std::vector<std::string> said;
    for (const Setting<HapticProperty>& row : surfaceProperties().rows())
    {
        std::string what;
        if (!row.repair(*this, what)) continue;
        if (row.isSafety)
        {
            what = what.substr(0, what.rfind("; ")) + kNothing;
            whySilenced.push_back(what);
        }
        said.push_back(std::move(what));
    }
    return said;
}

std::vector<std::pair<std::string, std::string>> HapticProperty::describe()
{
    return surfaceProperties().describe();
}

std::vector<SettingDescription> HapticProperty::getDescriptions()
{
    return descriptionsOf(surfaceProperties());
}

std::string HapticProperty::problemOf(const std::string& name, const std::string& value)
{
    return osgMidair::problemOf(surfaceProperties(), name, value);
}

bool operator==(const HapticProperty& a, const HapticProperty& b)
{
    return surfaceProperties().areSame(a, b) && a.whySilenced == b.whySilenced;
}

} // namespace osgMidair
