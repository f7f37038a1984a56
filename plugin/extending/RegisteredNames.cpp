#include "plugin/extending/RegisteredNames.h"

#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/hands/opening/HandOpening.h"

#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

std::string registeredNames(const std::string& setting)
{
    std::vector<std::string> names;
    if (setting == "solver") names = midair::bridge::ownSolverNames();
    if (setting == "hands")
        for (const std::string& name : midair::bridge::ownHandNames())
            names.push_back(name + ":");
    if (setting == "device")
        for (const midair::device::OwnScheme& scheme : midair::device::ownSchemes())
            names.push_back(scheme.name + ":");
    return fmt::format("{}", fmt::join(names, ", "));
}

} // namespace osgMidair
