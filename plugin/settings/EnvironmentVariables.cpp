#include "plugin/settings/EnvironmentVariables.h"

#include "device/limits/GuardedDevice.h"
#include "haptics/base/UserEnvironment.h"
#include "plugin/settings/AllSettings.h"

#include <osg/ApplicationUsage>

#include <algorithm>

namespace osgMidair
{

namespace
{

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
            if (!row.variable.empty()) found.push_back({"OSG_MIDAIR_" + row.variable, &row});
        return found;
    }();
    return all;
}

bool isCap(const Setting<HapticSettings>& setting)
{
    return setting.isSafety && std::holds_alternative<double HapticSettings::*>(setting.member);
}

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
        add("OSG_MIDAIR_TRUST <scene>",
            "scene: scene files open the devices and hands that they name, without a grant.");
        add("OSG_MIDAIR_GRANTS <file>",
            "Names that scene files may use, and the URIs they stand for; default "
            "~/.config/osgMidair/grants.");
        add("OSG_MIDAIR_SLICE <auto/cpu/gpu>",
            "Where the slice of a field is computed; auto: by the GPU where there is one.");
        add("OSG_MIDAIR_SIMD <plain/avx2/avx512>",
            "What the kernels run with, to find faults and to compare; default: the best that the "
            "processor has.");
        add("OSG_MIDAIR_REPORT <file>",
            "Write what haptic scenes did (counts, accuracy, latency, messages) as JSON at exit.");
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
    if (!settings.set(variable.setting->name, value, error))
        errors.push_back(variable.name + ": " + error);
    if (!HapticSettings::isLimit(settings.maxPressure, settings.maxAmplitude))
    {
        settings.isSilenced = true;
        errors.push_back(variable.name + " is \"" + value +
                         "\", which is out of range; nothing is played");
    }
    settings.maxAmplitude = std::min(settings.maxAmplitude, before.maxAmplitude);
    settings.maxPressure =
        midair::device::stricterPressure(settings.maxPressure, before.maxPressure);
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
}

} // namespace

HapticSettings Environment::apply(HapticSettings settings, std::vector<std::string>& errors)
{
    if (!HapticSettings::isLimit(settings.maxPressure, settings.maxAmplitude))
        settings.isSilenced = true; // repair() reports it, unless the user's limits replace it
    for (const Variable& variable : variables())
    {
        const auto user = midair::base::userVariable(variable.name);
        const auto now = midair::base::variableNow(variable.name);
        if (user) applyTo(settings, variable, *user, errors);
        if (now && now != user) restrictBy(settings, variable, *now, errors);
    }
    return settings;
}

std::string Environment::reportFile()
{
    return midair::base::userVariable("OSG_MIDAIR_REPORT").value_or("");
}

} // namespace osgMidair
