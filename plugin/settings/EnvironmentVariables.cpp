#include "plugin/settings/EnvironmentVariables.h"

#include "device/GuardedDevice.h"
#include "haptics/base/UserEnvironment.h"

#include <osg/ApplicationUsage>

#include <algorithm>

namespace osgMidair
{

namespace
{

const osg::ApplicationUsageProxy kUsage[] = {
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_DEVICE <uri>",
     "Device that haptic scenes drive instead of the one they name: sim:, record:FILE, null:, .."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_ARRAY <array>",
     "Array of haptic scenes instead of the one they name: octagon, board, or a JSON file."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_SOLVER <name>",
     "Solver of haptic scenes instead of the one they name."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_HANDS <uri>",
     "Where haptic scenes get hands from: recorded:FILE, recorded:FILE?loop, openxr:; none (or "
     "empty): from nowhere."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_REACH <metres>",
     "Haptic scenes solve only what is so near to a hand; 0: everything."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_MAX_PRESSURE <Pa>",
     "Haptic scenes give no control point more than this (peak), nor more than they say "
     "themselves."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_MAX_AMPLITUDE <0..1>",
     "Haptic scenes give no transducer more of full drive than this, nor more than they say "
     "themselves."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_TRUST <scene>",
     "scene: scene files open the devices and hands that they name, without a grant."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_GRANTS <file>",
     "Names that scene files may use, and the URIs they stand for; default "
     "~/.config/osgMidair/grants."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_CYCLE <fields>",
     "Haptic scenes play so many fields for shifted points in turn, which smooths what rests."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_SUBSETS <subsets>",
     "Haptic scenes play so many subsets of the points in turn: each less often, but harder."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_MONITOR <seconds>",
     "So often haptic scenes certify and measure a field, beside the solver; 0: never."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_ENABLED <true/false>",
     "false: haptic scenes leave the array silent."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_SLICE <auto/cpu/gpu>",
     "Where the slice of a field is computed; auto: by the GPU where there is one."},
    {osg::ApplicationUsage::ENVIRONMENTAL_VARIABLE,
     "OSG_MIDAIR_REPORT <file>",
     "Write what haptic scenes did (counts, accuracy, latency, messages) as JSON at exit."}};

} // namespace

namespace
{

struct Variable
{
    const char* name;
    const char* setting;
};

constexpr Variable kVariables[] = {{"OSG_MIDAIR_DEVICE", "device"},
                                   {"OSG_MIDAIR_ARRAY", "array"},
                                   {"OSG_MIDAIR_SOLVER", "solver"},
                                   {"OSG_MIDAIR_HANDS", "hands"},
                                   {"OSG_MIDAIR_REACH", "reach"},
                                   {"OSG_MIDAIR_MAX_PRESSURE", "maxPressure"},
                                   {"OSG_MIDAIR_MAX_AMPLITUDE", "maxAmplitude"},
                                   {"OSG_MIDAIR_CYCLE", "cycle"},
                                   {"OSG_MIDAIR_SUBSETS", "subsets"},
                                   {"OSG_MIDAIR_MONITOR", "monitorInterval"},
                                   {"OSG_MIDAIR_ENABLED", "enabled"}};

/// Sets what \a variable says; of limits the stricter one counts, and one that can't be kept silences.
void applyTo(HapticSettings& settings,
             const Variable& variable,
             const std::string& value,
             std::vector<std::string>& errors)
{
    // Empty is as good as missing, but for hands: there it takes them away.
    if (value.empty() && std::string(variable.setting) != "hands") return;
    const HapticSettings before = settings;
    std::string error;
    if (!settings.set(variable.setting, value, error))
        errors.push_back(std::string(variable.name) + ": " + error);
    if (!HapticSettings::isLimit(settings.maxPressure, settings.maxAmplitude))
    {
        settings.isSilenced = true;
        errors.push_back(std::string(variable.name) + " is \"" + value +
                         "\", which is out of range; nothing is played");
    }
    settings.maxAmplitude = std::min(settings.maxAmplitude, before.maxAmplitude);
    settings.maxPressure =
        midair::device::stricterPressure(settings.maxPressure, before.maxPressure);
}

/// What was set after the program began may be a file's doing: it takes away, and gives nothing.
void restrictBy(HapticSettings& settings,
                const Variable& variable,
                const std::string& value,
                std::vector<std::string>& errors)
{
    const std::string setting = variable.setting;
    HapticSettings asked = settings;
    applyTo(asked, variable, value, errors);
    const bool takesHands = setting == "hands" && (asked.hands.empty() || asked.hands == "none");
    if (setting == "enabled")
        settings.enabled = settings.enabled && asked.enabled;
    else if ((setting != "device" && setting != "array" && setting != "hands") || takesHands)
        settings = asked;
    else
        errors.push_back(std::string(variable.name) +
                         " was set after the program began, which a file can do: it is not used");
    settings.isSilenced = settings.isSilenced || asked.isSilenced;
}

} // namespace

HapticSettings Environment::apply(HapticSettings settings, std::vector<std::string>& errors)
{
    if (!HapticSettings::isLimit(settings.maxPressure, settings.maxAmplitude))
        settings.isSilenced = true; // told by repair(), but for what the user's own limits replace
    for (const Variable& variable : kVariables)
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
