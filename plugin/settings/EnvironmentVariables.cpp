#include "plugin/settings/EnvironmentVariables.h"

#include "device/limits/GuardedDevice.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/NearestWord.h"
#include "plugin/settings/AllSettings.h"

#include <osg/ApplicationUsage>

#include <algorithm>
#include <array>

namespace osgMidair
{

namespace
{

const std::string kPrefix = "OSG_MIDAIR_";

/// A setting and the name of its environment variable.
struct Variable
{
    std::string name;
    const Setting<HapticSettings>* setting;
};

const std::vector<Variable>& variables()
{
    static const std::vector<Variable> all = []
    {
        std::vector<Variable> found;
        for (const Setting<HapticSettings>& row : sceneSettings().rows())
            if (!row.variable.empty()) found.push_back({kPrefix + row.variable, &row});
        return found;
    }();
    return all;
}

bool isCap(const Setting<HapticSettings>& setting)
{
    return setting.name == "maxPressure" || setting.name == "maxAmplitude" ||
           setting.name == "earLimit";
}

/// A variable that is no setting of scenes.
struct Other
{
    const char* name;
    const char* value;
    const char* text;
};

constexpr std::array<Other, 7> kOthers = {
    {{"TRUST",
      "scene",
      "scene: scene files open the devices and hands that they name, without a grant."},
     {"GRANTS",
      "file",
      "Names that scene files may use, and the URIs they stand for; default "
      "~/.config/osgMidair/grants."},
     {"ARRAYS", "folders", "Where arrays are looked up by their names first; with : between."},
     {"MATERIALS", "file", "Materials of your own, besides the kit's."},
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
        for (const Variable& variable : variables())
            add(variable.name + " <" + variable.setting->name + ">",
                (isCap(*variable.setting) ? "Of this and what haptic scenes say the stricter: "
                                          : "Instead of what haptic scenes say: ") +
                    variable.setting->summary());
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

/// Sets the setting of \a variable to \a value. Of two limits the stricter one stays; a limit that
/// is out of range silences the array.
void applyTo(HapticSettings& settings,
             const Variable& variable,
             const std::string& value,
             std::vector<std::string>& errors)
{
    // An empty variable counts as missing, except for hands, where it removes the source.
    if (value.empty() && variable.setting->name != "hands") return;
    const HapticSettings before = settings;
    std::string error;
    const bool isSet = settings.set(variable.setting->name, value, error);
    if (settings.whySilenced.size() > before.whySilenced.size())
        settings.whySilenced.back() = variable.name + ": " + error;
    else if (!isSet)
        errors.push_back(variable.name + ": " + error);
    if (isCap(*variable.setting) && !variable.setting->holds(settings))
    {
        settings.isSilenced = true;
        settings.whySilenced.push_back(variable.name + " is \"" + value + "\", should be " +
                                       variable.setting->values() + "; nothing is played");
        settings.maxAmplitude = before.maxAmplitude; // so that repair() doesn't report it, too
        settings.maxPressure = before.maxPressure;
        settings.earLimit = before.earLimit;
    }
    settings.maxAmplitude = std::min(settings.maxAmplitude, before.maxAmplitude);
    settings.maxPressure =
        midair::device::stricterPressure(settings.maxPressure, before.maxPressure);
    settings.earLimit = midair::device::stricterPressure(settings.earLimit, before.earLimit);
}

/// Applies a variable that was set after the program began. A scene file can do that, so it may
/// only restrict what is played.
void restrictBy(HapticSettings& settings,
                const Variable& variable,
                const std::string& value,
                std::vector<std::string>& errors)
{
    const std::string& setting = variable.setting->name;
    HapticSettings asked = settings;
    applyTo(asked, variable, value, errors);
    const bool takesHands = setting == "hands" && (asked.hands.empty() || asked.hands == "none");
    if (setting == "enabled")
        settings.enabled = settings.enabled && asked.enabled;
    else if (!wishOf(setting) || takesHands)
        settings = asked;
    else
        errors.push_back(variable.name +
                         " was set after the program began, which a file can do: it is not used");
    settings.isSilenced = settings.isSilenced || asked.isSilenced;
    settings.whySilenced = asked.whySilenced;
}

/// Tells variables that look like the kit's and aren't. One that may be a limit misspelt silences.
void tellUnknown(HapticSettings& settings, std::vector<std::string>& errors)
{
    std::vector<std::string> known;
    known.reserve(kOthers.size() + variables().size());
    for (const Other& other : kOthers)
        known.emplace_back(other.name);
    for (const Variable& variable : variables())
        known.push_back(variable.setting->variable);
    for (const std::string& name : midair::base::variablesNow(kPrefix))
    {
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        std::string error =
            kPrefix + name + " is no variable" + midair::base::didYouMean(name, known);
        const std::vector<std::string> nearest = midair::base::nearestWords(name, known);
        const bool isSafety = std::any_of(
            variables().begin(),
            variables().end(),
            [&nearest](const Variable& variable)
            {
                const Setting<HapticSettings>& row = *variable.setting;
                return row.isSafety && std::count(nearest.begin(), nearest.end(), row.variable) > 0;
            });
        if (isSafety)
        {
            error += "; nothing is played";
            settings.isSilenced = true;
            settings.whySilenced.push_back(error);
        }
        errors.push_back(error);
    }
}

} // namespace

HapticSettings Environment::apply(HapticSettings settings, std::vector<std::string>& errors)
{
    // The user's limits may replace one that is out of range, which stays a reason for silence.
    HapticSettings repaired = settings;
    repaired.repair();
    settings.isSilenced = repaired.isSilenced;
    settings.whySilenced = repaired.whySilenced;
    for (const Variable& variable : variables())
    {
        const auto user = midair::base::userVariable(variable.name);
        const auto now = midair::base::variableNow(variable.name);
        if (user) applyTo(settings, variable, *user, errors);
        if (now && now != user) restrictBy(settings, variable, *now, errors);
    }
    tellUnknown(settings, errors);
    return settings;
}

std::string Environment::reportFile()
{
    return midair::base::userVariable("OSG_MIDAIR_REPORT").value_or("");
}

void Environment::trustVariablesOfProgram()
{
    midair::base::trustVariablesOfProgram();
}

} // namespace osgMidair
