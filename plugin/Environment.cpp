#include "Environment.h"

#include <osg/ApplicationUsage>

#include <cstdlib>

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
     "Haptic scenes give no control point more than this (peak); 0: no cap."},
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

HapticSettings Environment::apply(HapticSettings settings, std::vector<std::string>& errors)
{
    bool silent = false;
    for (const auto& [variable, name] :
         {std::pair<const char*, const char*>{"OSG_MIDAIR_DEVICE", "device"},
          {"OSG_MIDAIR_ARRAY", "array"},
          {"OSG_MIDAIR_SOLVER", "solver"},
          {"OSG_MIDAIR_HANDS", "hands"},
          {"OSG_MIDAIR_REACH", "reach"},
          {"OSG_MIDAIR_MAX_PRESSURE", "maxPressure"},
          {"OSG_MIDAIR_MAX_AMPLITUDE", "maxAmplitude"},
          {"OSG_MIDAIR_CYCLE", "cycle"},
          {"OSG_MIDAIR_SUBSETS", "subsets"},
          {"OSG_MIDAIR_MONITOR", "monitorInterval"},
          {"OSG_MIDAIR_ENABLED", "enabled"}})
    {
        const char* value =
            std::getenv(variable); // NOLINT(concurrency-mt-unsafe): OSG itself reads it so
        std::string error;
        // Empty is as good as missing, but for hands: there it takes them away.
        if (!value || (!*value && std::string(name) != "hands")) continue;
        const double amplitude = settings.maxAmplitude;
        const bool enabled = settings.enabled;
        if (!settings.set(name, value, error))
            errors.push_back(std::string(variable) + ": " + error);
        silent = silent || (enabled && !settings.enabled);
        if (std::string(name) == "maxAmplitude" && settings.maxAmplitude > amplitude)
            settings.maxAmplitude = amplitude; // the stricter one counts
    }
    if (silent) settings.enabled = false; // whatever comes after it says
    return settings;
}

std::string Environment::reportFile()
{
    const char* value = std::getenv("OSG_MIDAIR_REPORT"); // NOLINT(concurrency-mt-unsafe)
    return value ? value : "";
}

} // namespace osgMidair
