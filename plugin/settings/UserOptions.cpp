#include "plugin/settings/UserOptions.h"

#include "plugin/settings/Assignments.h"
#include "plugin/settings/Grants.h"

#include <osg/Notify>
#include <osgDB/Registry>

#include <algorithm>

namespace osgMidair
{

std::string userOptions()
{
    const osgDB::Options* options = osgDB::Registry::instance()->getOptions();
    return options ? options->getOptionString() : std::string();
}

void applyUserOptions(HapticSettings& settings)
{
    const auto known = HapticSettings::describe();
    const auto take = [&](const std::string& name, const std::string& value)
    {
        const auto isNamed = [&name](const auto& setting) { return setting.first == name; };
        std::string error = name.empty() ? cutListWarning(value) : std::string();
        // Options are shared by all readers: what isn't a setting is another's.
        if (std::any_of(known.begin(), known.end(), isNamed)) settings.set(name, value, error);
        if (!error.empty()) OSG_WARN << "osgMidair: options: " << printable(error) << std::endl;
    };
    forEachAssignment(userOptions(), take);
}

void makeWishes(HapticSettings& settings, const std::string& folder)
{
    HapticSettings user;
    user.array = user.device = user.hands = "\n"; // none that anybody names
    const auto take = [&user](const std::string& name, const std::string& value)
    {
        std::string ignored;
        if (name == "array" || name == "device" || name == "hands") user.set(name, value, ignored);
    };
    forEachAssignment(userOptions(), take);
    const HapticSettings none;
    if (settings.array != user.array && settings.array != none.array)
        settings.wishes.array = settings.array;
    if (settings.device != user.device && settings.device != none.device)
        settings.wishes.device = settings.device;
    if (settings.hands != user.hands && settings.hands != none.hands)
        settings.wishes.hands = settings.hands;
    const HapticWishes& wishes = settings.wishes;
    if (wishes.array || wishes.device || wishes.hands) settings.wishes.folder = folder;
}

std::string cutListWarning(const std::string& word)
{
    static const char* const schemes[] = {
        "sim:", "null:", "usb:", "record:", "play:", "sonicsurface:", "ultraino:", "openmpd:"};
    const bool isDevice = std::any_of(std::begin(schemes),
                                      std::end(schemes),
                                      [&word](const std::string& scheme)
                                      { return word.compare(0, scheme.size(), scheme) == 0; });
    if (!isDevice) return {};
    return "\"" + word +
           "\" stands alone and is not used: a list of devices has to be in quotes, "
           "device=\"usb:,record:FILE\"";
}

} // namespace osgMidair
