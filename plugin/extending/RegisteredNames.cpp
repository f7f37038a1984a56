#include "plugin/extending/RegisteredNames.h"

#include "device/opening/DeviceRegistry.h"
#include "plugin/extending/HandSourceRegistry.h"
#include "plugin/extending/SolverRegistry.h"

#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

std::string registeredNames(const std::string& setting)
{
    std::vector<std::string> names;
    if (setting == "solver") names = SolverRegistry::names();
    if (setting == "hands")
        for (const std::string& name : HandSourceRegistry::names())
            names.push_back(name + ":");
    if (setting == "device")
        for (const midair::device::OwnScheme& scheme : midair::device::ownSchemes())
            names.push_back(scheme.name + ":");
    return fmt::format("{}", fmt::join(names, ", "));
}

} // namespace osgMidair
