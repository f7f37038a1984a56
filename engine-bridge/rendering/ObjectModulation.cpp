#include "engine-bridge/rendering/ObjectModulation.h"

#include "haptics/base/text/Number.h"

#include <set>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

bool isModulated(const HapticProperties& properties)
{
    return properties.modulationFrequency_Hz > 0.0;
}

const HapticObject* leaderOf(const std::vector<HapticObject>& objects)
{
    const HapticObject* leader = nullptr;
    for (const HapticObject& object : objects)
        if (isModulated(object.properties) && object.properties.modulationDepth > 0.0 &&
            (!leader || object.properties.priority > leader->properties.priority))
            leader = &object;
    return leader;
}

// One message for any number of objects.
void tellOfOthers(const std::vector<HapticObject>& objects,
                  const HapticObject& leader,
                  const std::set<std::size_t>& others,
                  base::MessageLog& messages)
{
    if (others.empty()) return;
    const HapticObject& first = objects[*others.begin()];
    const std::string more =
        others.size() > 1 ? fmt::format(" (and so are {} more)", others.size() - 1) : "";
    messages.say({base::MessageCode::MODULATION_FREQUENCY,
                  fmt::format("{}: is modulated at {} Hz like {}, not at {} Hz{}: the array plays "
                              "one field at a time",
                              first.path,
                              base::exactNumber(leader.properties.modulationFrequency_Hz),
                              leader.path,
                              base::exactNumber(first.properties.modulationFrequency_Hz),
                              more),
                  first.path});
}

} // namespace

haptics::ModulationPlan modulationOf(const std::vector<HapticObject>& objects,
                                     const haptics::ControlPoints& points,
                                     const haptics::ModulatorOptions& everything,
                                     base::MessageLog& messages)
{
    haptics::ModulationPlan plan;
    const HapticObject* leader = leaderOf(objects);
    if (!leader || points.object.empty()) return plan;
    if (everything.amplitudeRate_Hz > 0.0)
    {
        messages.say({base::MessageCode::MODULATION_OVERRIDDEN,
                      "the scene's own modulation applies to all objects; the modulation of " +
                          leader->path + " is not played"});
        return plan;
    }
    plan.rate_Hz = leader->properties.modulationFrequency_Hz;
    plan.depth.resize(points.size());
    std::set<std::size_t> others; // objects with another frequency
    for (Eigen::Index l = 0; l < plan.depth.size(); ++l)
    {
        const auto index = static_cast<std::size_t>(points.object[static_cast<std::size_t>(l)]);
        const HapticProperties& p = objects[index].properties;
        plan.depth[l] = isModulated(p) ? p.modulationDepth : 0.0;
        if (!isModulated(p) || p.modulationFrequency_Hz == plan.rate_Hz) continue;
        others.insert(index);
    }
    tellOfOthers(objects, *leader, others, messages);
    // The modulated objects may have no points.
    if (plan.depth.size() == 0 || plan.depth.maxCoeff() == 0.0) plan = {};
    return plan;
}

} // namespace midair::bridge
