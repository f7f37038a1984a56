#include "plugin/settings/UserOptions.h"

#include "device/ArrayDevice.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/Grants.h"

#include <osg/Notify>
#include <osgDB/Registry>

#include <algorithm>
#include <memory>
#include <mutex>
#include <set>

namespace osgMidair
{

namespace
{

/// Returns the assignments in the user's options; each option string is parsed once.
std::shared_ptr<const std::vector<Assignment>> userAssignments()
{
    static std::mutex mutex;
    static std::string text;
    static std::shared_ptr<const std::vector<Assignment>> known;
    const std::string now = userOptions();
    const std::lock_guard<std::mutex> lock(mutex);
    if (known && text == now) return known;
    std::vector<Assignment> all;
    forEachAssignment(now, [&all](const Assignment& one) { all.push_back(one); });
    text = now;
    known = std::make_shared<const std::vector<Assignment>>(std::move(all));
    return known;
}

/// Returns true if the last assignment to \a row in the user's options sets it to \a value.
bool isUsers(const Setting<HapticSettings>& row, const std::string& value)
{
    const auto all = userAssignments();
    const auto last = std::find_if(
        all->rbegin(), all->rend(), [&row](const Assignment& one) { return one.name == row.name; });
    return last != all->rend() && last->value == value;
}

// Nobody knows which of two was meant.
void refuseSecond(const std::string& name, HapticSettings& settings, std::string& error)
{
    const bool isSafety = sceneSettings().concernsSafety(name);
    error = name + " is given twice" + (isSafety ? "; nothing is played" : "; the first counts");
    if (!isSafety) return;
    settings.isSilenced = true;
    settings.whySilenced.push_back(error);
}

} // namespace

std::string userOptions()
{
    const osgDB::Options* options = osgDB::Registry::instance()->getOptions();
    return options ? options->getOptionString() : std::string();
}

void applyUserOptions(HapticSettings& settings)
{
    std::set<std::string> seen;
    for (const Assignment& one : *userAssignments())
    {
        std::string error = one.name.empty() ? cutListWarning(one.value) : std::string();
        // All readers share the options: names that aren't settings are for other readers, but for
        // a limit that is misspelt.
        const bool isOthers = surfaceProperties().find(one.name) && one.name != "enabled";
        if (sceneSettings().find(one.name) && !seen.insert(one.name).second)
            refuseSecond(one.name, settings, error);
        else if (sceneSettings().find(one.name) ||
                 (!isOthers && sceneSettings().concernsSafety(one.name)))
            settings.set(one.name, one.value, error);
        if (error.empty()) continue;
        OSG_WARN << "osgMidair: options: " << printable(error) << std::endl;
    }
}

void makeWishes(HapticSettings& settings, const std::string& folder)
{
    const HapticSettings none;
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
    {
        if (!row.isWish) continue;
        const auto member = std::get<std::string HapticSettings::*>(row.member);
        const std::string& value = settings.*member;
        if (value != none.*member && !isUsers(row, value)) settings.wishes.asked[row.name] = value;
    }
    if (!settings.wishes.asked.empty()) settings.wishes.folder = folder;
}

std::string cutListWarning(const std::string& word)
{
    const std::vector<std::string> schemes = midair::device::deviceSchemes();
    const bool isDevice = std::any_of(schemes.begin(),
                                      schemes.end(),
                                      [&word](const std::string& scheme)
                                      { return word.rfind(scheme + ":", 0) == 0; });
    if (!isDevice) return {};
    return "\"" + word +
           "\" stands alone and is not used: a list of devices has to be in quotes, "
           "device=\"usb:,record:FILE\"";
}

} // namespace osgMidair
