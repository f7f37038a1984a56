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

/// The name of a setting's environment variable; empty: it has none.
std::string variableOf(const Row& row)
{
    return row.variable.empty() ? "" : kPrefix + row.variable;
}

/// True for what midair::device::capsOfUser() reads.
bool isCap(const Row& row)
{
    const std::vector<std::string>& caps = midair::device::userCapVariables();
    return std::find(caps.begin(), caps.end(), variableOf(row)) != caps.end();
}

/// A variable that is no setting of scenes.
struct Other
{
    const char* name;
    const char* value;
    const char* text;
};

constexpr std::array<Other, 8> kOthers = {
    {{"TRUST",
      "scene",
      "scene: scene files open the devices and hands that they name, without a grant."},
     {"GRANTS",
      "file",
      "Names that scene files may use, and the URIs they stand for; default "
      "~/.config/osgMidair/grants."},
     {"ARRAYS", "folders", "Where arrays are looked up by their names first; with : between."},
     {"MATERIALS", "file", "Materials of your own, besides the kit's."},
     {"DISPLAY",
      "file",
      "The screen in the room that a viewer's window fills, FILE.display.json; sim:FILE: what an "
      "eye would see through its optics."},
     {"SLICE",
      "auto/cpu/gpu",
      "Where the slice of a field is computed; auto: by the GPU where there is one."},
     {"SIMD",
      "plain/avx2/avx512",
      "What the kernels run with, to find faults and to compare; default: the best that the "
      "processor has."},
     {"REPORT",
      "file",
      "Write what haptic scenes did (counts, accuracy, latency, messages) as JSON at exit."}}};

/// Registers the text that --help-env lists.
struct Usage
{
    Usage()
    {
        for (const Row& row : sceneSettings().rows())
            if (!row.variable.empty())
                add(variableOf(row) + " <" + row.name + ">",
                    (row.name == "earPoints" ? "Besides what haptic scenes say: "
                     : isCap(row)            ? "Of this and what haptic scenes say the stricter: "
                                             : "Instead of what haptic scenes say: ") +
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
    if (row.name == "enabled")
        settings.enabled = settings.enabled && asked.enabled;
    else if (!row.isWish || takesHands)
        settings = asked;
    else
        errors.push_back(variableOf(row) +
                         " was set after the program began, which a file can do: it is not used");
    settings.isSilenced = settings.isSilenced || asked.isSilenced;
    settings.whySilenced = asked.whySilenced;
}

/// Tells variables that look like the kit's and aren't. One that may be a limit misspelt silences.
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
            kPrefix + name + " is no variable" + midair::base::didYouMean(name, known);
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

/// Returns true if the last assignment to \a row in the user's options sets it to \a value.
bool isUsers(const Row& row, const std::string& value)
{
    const auto all = userAssignments();
    const auto last = std::find_if(
        all->rbegin(), all->rend(), [&row](const Assignment& one) { return one.name == row.name; });
    return last != all->rend() && last->value == value;
}

} // namespace

HapticSettings Environment::replace(HapticSettings settings, std::vector<std::string>& errors)
{
    // A variable may replace a value that is out of range, which stays a reason for silence.
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
    tellUnknown(settings, errors);
    return settings;
}

HapticSettings Environment::restrict(HapticSettings settings)
{
    const midair::device::UserCaps caps = midair::device::capsOfUser();
    midair::bridge::SceneSettings& scene = settings;
    scene = midair::bridge::restricted(scene, caps);
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
    for (const Assignment& one : *userAssignments())
    {
        std::string error = one.name.empty() ? cutListWarning(one.value) : std::string();
        // All readers share the options: names that aren't settings are for other readers, but for
        // a limit that is misspelt.
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
