#include "plugin/settings/UserOptions.h"

#include "device/ArrayDevice.h"
#include "device/limits/UserLimits.h"
#include "engine-bridge/player/SceneOptions.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Words.h"
#include "haptics/base/threads/Mutex.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/Grants.h"

#include <osg/ApplicationUsage>
#include <osg/Notify>
#include <osgDB/Registry>

#include <algorithm>
#include <array>
#include <memory>
#include <set>

namespace osgMidair
{

namespace
{

const std::string kPrefix = "OSG_MIDAIR_";

using Row = Setting<HapticSettings>;

/// Returns the name of a setting's environment variable; empty: none.
std::string variableOf(const Row& row)
{
    return row.variable.empty() ? "" : kPrefix + row.variable;
}

/// True for the caps read by midair::device::capsOfUser().
bool isCap(const Row& row)
{
    const std::vector<std::string>& caps = midair::device::userCapVariables();
    return std::find(caps.begin(), caps.end(), variableOf(row)) != caps.end();
}

/// A variable that is no scene setting.
struct Other
{
    const char* name;
    const char* value;
    const char* text;
};

constexpr std::array<Other, 8> kOthers = {
    {{"TRUST", "scene", "scene: scene files may open the devices and hands that they name."},
     {"GRANTS",
      "file",
      "File of names that scene files may use, and their URIs; default "
      "~/.config/osgMidair/grants."},
     {"ARRAYS", "folders", "Folders searched first for arrays by name; separated by :."},
     {"MATERIALS", "file", "Materials of your own, besides the kit's."},
     {"DISPLAY",
      "file",
      "Display that a viewer's window fills, FILE.display.json; sim:FILE simulates the view "
      "through its optics."},
     {"SLICE",
      "auto/cpu/gpu",
      "Processor for the slice of a field; auto: the GPU if there is one."},
     {"SIMD",
      "plain/avx2/avx512",
      "Instruction set of the kernels, for debugging and comparison; default: the best that the "
      "processor has."},
     {"REPORT",
      "file",
      "Write a report of haptic scenes (counts, accuracy, latency, messages) as JSON at exit."}}};

/// Registers the text that --help-env lists.
struct Usage
{
    Usage()
    {
        for (const Row& row : sceneSettings().rows())
            if (!row.variable.empty())
                add(variableOf(row) + " <" + row.name + ">",
                    (row.name == "earPoints" ? "In addition to a scene's own: "
                     : isCap(row)            ? "The stricter of this and a scene's own value: "
                                             : "Overrides a scene's value: ") +
                        row.summary());
        for (const Other& other : kOthers)
            add(kPrefix + other.name + " <" + other.value + ">", other.text);
    }

    static void add(const std::string& option, const std::string& explanation)
    {
        osg::ApplicationUsage::instance()->addUsageExplanation(
            osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE, option, explanation);
    }
};

const Usage kUsage;

/// Sets the setting of \a row to \a value of its variable.
void applyTo(HapticSettings& settings,
             const Row& row,
             const std::string& value,
             std::vector<std::string>& errors)
{
    // An empty variable counts as missing, except for hands, where it removes the source.
    if (value.empty() && row.name != "hands") return;
    const HapticSettings before = settings;
    std::string error;
    const bool isSet = settings.set(row.name, value, error);
    if (settings.whySilenced.size() > before.whySilenced.size())
        settings.whySilenced.back() = variableOf(row) + ": " + error;
    else if (!isSet)
        errors.push_back(variableOf(row) + ": " + error);
}

/// Applies a variable that was set after the program began. A scene file can do that, so it may
/// only restrict what is played.
void restrictBy(HapticSettings& settings,
                const Row& row,
                const std::string& value,
                std::vector<std::string>& errors)
{
    HapticSettings asked = settings;
    applyTo(asked, row, value, errors);
    const bool takesHands = row.name == "hands" && (asked.hands.empty() || asked.hands == "none");
    if (!row.isWish || takesHands)
        settings = asked;
    else
        errors.push_back(
            variableOf(row) +
            " was set after the program began and is ignored, because a file could have set it");
    settings.isSilenced = settings.isSilenced || asked.isSilenced;
    settings.whySilenced = asked.whySilenced;
}

/// Reports variables that look like the kit's but aren't. One that may be a misspelt limit
/// silences.
void tellUnknown(HapticSettings& settings, std::vector<std::string>& errors)
{
    std::vector<std::string> known;
    known.reserve(kOthers.size() + sceneSettings().rows().size());
    for (const Other& other : kOthers)
        known.emplace_back(other.name);
    for (const Row& row : sceneSettings().rows())
        if (!row.variable.empty()) known.push_back(row.variable);
    for (const std::string& name : midair::base::variablesNow(kPrefix))
    {
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        std::string error =
            kPrefix + name + " is an unknown variable" + midair::base::didYouMean(name, known);
        const std::vector<std::string> nearest = midair::base::nearestWords(name, known);
        const std::vector<Row>& rows = sceneSettings().rows();
        const bool isSafety = std::any_of(
            rows.begin(),
            rows.end(),
            [&nearest](const Row& row)
            { return row.isSafety && std::count(nearest.begin(), nearest.end(), row.variable); });
        if (isSafety)
        {
            error += "; nothing is played";
            silence(settings, error);
        }
        errors.push_back(error);
    }
}

/// Returns the assignments in the user's options; each option string is parsed once.
std::shared_ptr<const std::vector<Assignment>> userAssignments()
{
    struct Parsed
    {
        midair::base::Mutex mutex;
        std::string text MIDAIR_GUARDED_BY(mutex);
        std::shared_ptr<const std::vector<Assignment>> known MIDAIR_GUARDED_BY(mutex);
    };
    static Parsed parsed;
    const std::string now = userOptions();
    const midair::base::Lock lock(parsed.mutex);
    if (parsed.known && parsed.text == now) return parsed.known;
    parsed.text = now;
    parsed.known = std::make_shared<const std::vector<Assignment>>(assignmentsIn(now));
    return parsed.known;
}

/// Returns true if the user's options last set \a row to \a value.
bool isUsers(const Row& row, const std::string& value)
{
    const auto all = userAssignments();
    const auto last = std::find_if(
        all->rbegin(), all->rend(), [&row](const Assignment& one) { return one.name == row.name; });
    return last != all->rend() && last->value == value;
}

/// "maxPressure" of "maxPressure 800" and "maxPressure:800".
std::string firstOf(const std::string& word)
{
    return word.substr(0, word.find_first_of(": "));
}

} // namespace

HapticSettings Environment::replace(HapticSettings settings, std::vector<std::string>& errors)
{
    // A variable may replace a value out of range, which still silences.
    HapticSettings repaired = settings;
    repaired.repair();
    settings.isSilenced = repaired.isSilenced;
    settings.whySilenced = repaired.whySilenced;
    for (const Row& row : sceneSettings().rows())
    {
        if (row.variable.empty() || isCap(row)) continue;
        const auto user = midair::base::userVariable(variableOf(row));
        const auto now = midair::base::variableNow(variableOf(row));
        if (user) applyTo(settings, row, *user, errors);
        if (now && now != user) restrictBy(settings, row, *now, errors);
    }
    if (isByMouse() && settings.hands == "mouse:" && settings.render == HapticSettings::OBJECT &&
        !midair::base::userVariable(kPrefix + "RENDER"))
        settings.render = HapticSettings::AUTO;
    tellUnknown(settings, errors);
    return settings;
}

bool Environment::isByMouse()
{
    return midair::base::userVariable(kPrefix + "HANDS") == "mouse:";
}

HapticSettings Environment::restrict(HapticSettings settings)
{
    const midair::device::UserCaps caps = midair::device::capsOfUser();
    midair::bridge::SceneSettings& scene = settings;
    scene = midair::bridge::restricted(scene, caps);
    settings.enabled = settings.enabled && !caps.isSilencing;
    settings.isSilenced = settings.isSilenced || !caps.wrong.empty();
    settings.whySilenced.insert(settings.whySilenced.end(), caps.wrong.begin(), caps.wrong.end());
    return settings;
}

std::string Environment::reportFile()
{
    return midair::base::userVariable("OSG_MIDAIR_REPORT").value_or("");
}

std::string userOptions()
{
    const osgDB::Options* options = osgDB::Registry::instance()->getOptions();
    return options ? options->getOptionString() : std::string();
}

void applyUserOptions(HapticSettings& settings)
{
    std::set<std::string> seen;
    const std::vector<std::string> names = optionNames();
    for (const Assignment& one : *userAssignments())
    {
        std::string error = one.name.empty() ? wordWarning(one.value) : std::string();
        if (!error.empty() && isSafetyWord(one.value))
            silence(settings, error += "; nothing is played");
        // All readers share the options: other names belong to other readers, except a misspelt
        // limit.
        const bool isOthers = surfaceProperties().find(one.name) && one.name != "enabled";
        if (sceneSettings().find(one.name) && !seen.insert(one.name).second)
        {
            const bool isSafety = sceneSettings().concernsSafety(one.name);
            error = givenTwice(one.name, isSafety);
            if (isSafety) silence(settings, error);
        }
        else if (sceneSettings().find(one.name) ||
                 (!isOthers && sceneSettings().concernsSafety(one.name)))
            settings.set(one.name, one.value, error);
        else if (!one.name.empty() && std::count(names.begin(), names.end(), one.name) == 0)
            if (const std::string meant = midair::base::didYouMean(one.name, names); !meant.empty())
                error = "unknown option \"" + one.name + "\"" + meant;
        if (error.empty()) continue;
        OSG_WARN << "osgMidair: options: " << printable(error) << std::endl;
    }
}

void makeWishes(HapticSettings& settings, const std::string& folder)
{
    const HapticSettings none;
    for (const Row& row : sceneSettings().rows())
    {
        if (!row.isWish) continue;
        const auto member = std::get<std::string HapticSettings::*>(row.member);
        const std::string& value = settings.*member;
        if (value != none.*member && !isUsers(row, value)) settings.wishes.asked[row.name] = value;
    }
    if (!settings.wishes.asked.empty()) settings.wishes.folder = folder;
}

std::vector<std::string> optionNames()
{
    std::vector<std::string> names = sceneSettings().names();
    for (const std::string& property : surfaceProperties().names())
        names.push_back(property);
    names.insert(names.end(), std::begin(kPlacingOptions), std::end(kPlacingOptions));
    return names;
}

std::string wordWarning(const std::string& word)
{
    const std::vector<std::string> schemes = midair::device::deviceSchemes();
    const bool isDevice = std::any_of(schemes.begin(),
                                      schemes.end(),
                                      [&word](const std::string& scheme)
                                      { return word.rfind(scheme + ":", 0) == 0; });
    if (isDevice)
        return "\"" + word +
               "\" is ignored: put a list of devices in quotes, "
               "device=\"usb:,record:FILE\"";
    const std::string name = firstOf(word);
    const std::vector<std::string> names = optionNames();
    if (std::find(names.begin(), names.end(), name) == names.end()) return {};
    const std::string value =
        name.size() < word.size() ? midair::base::trimmed(word.substr(name.size() + 1)) : "VALUE";
    return "\"" + word + "\" is no option: it should be " + name + "=" + value;
}

bool isSafetyWord(const std::string& word)
{
    const Row* row = sceneSettings().find(firstOf(word));
    return (row && row->isSafety) || firstOf(word) == "pressure";
}

} // namespace osgMidair
