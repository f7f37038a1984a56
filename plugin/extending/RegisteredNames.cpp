#include "plugin/extending/RegisteredNames.h"

#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/extending/ArrayDriver.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/heads/HeadOpening.h"

#include <osgMidair/DeviceDriver>
#include <osgMidair/FieldSolver>

#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

bool registerDevice(const std::string& scheme, DeviceDriverFactory make, std::string& error)
{
    midair::bridge::ArrayDriverFactory adapted;
    if (make)
        adapted = [make = std::move(make)]() -> std::shared_ptr<ArrayDriver>
        {
            osg::ref_ptr<DeviceDriver> driver = make();
            ArrayDriver* const called = driver.get();
            if (!called) return nullptr;
            return {called, [driver](ArrayDriver*) mutable { driver = nullptr; }};
        };
    return midair::bridge::registerDriver(scheme, std::move(adapted), error);
}

bool registerSolver(const std::string& name, FieldSolverFactory make, std::string& error)
{
    midair::bridge::FieldMethodFactory adapted;
    if (make)
        adapted = [make = std::move(make)]() -> std::shared_ptr<FieldMethod>
        {
            osg::ref_ptr<FieldSolver> solver = make();
            FieldMethod* const called = solver.get();
            if (!called) return nullptr;
            return {called, [solver](FieldMethod*) mutable { solver = nullptr; }};
        };
    return midair::bridge::registerMethod(name, std::move(adapted), error);
}

std::string registeredNames(const std::string& setting)
{
    std::vector<std::string> names;
    if (setting == "solver") names = midair::bridge::ownSolverNames();
    if (setting == "hands")
        for (const std::string& name : midair::bridge::ownHandNames())
            names.push_back(name + ":");
    if (setting == "heads")
        for (const std::string& name : midair::bridge::ownHeadNames())
            names.push_back(name + ":");
    if (setting == "device")
        for (const midair::device::OwnScheme& scheme : midair::device::ownSchemes())
            names.push_back(scheme.name + ":");
    return fmt::format("{}", fmt::join(names, ", "));
}

} // namespace osgMidair
