// Replaces the other sources here if cpp-httplib wasn't found: --monitor fails with a message.

#include "samples/shared/monitor/SceneMonitor.h"

#include <stdexcept>

#include <CLI/CLI.hpp>

namespace midair::samples
{

namespace
{

constexpr const char* kNotHere =
    "the operator's page is not in this build; configure it with -DMIDAIR_MONITOR=ON";

}

void addMonitorOptions(CLI::App& app, MonitorOptions& options)
{
    app.add_option("--monitor", options.address, kNotHere)
        ->check(CLI::Validator([](const std::string&) { return std::string(kNotHere); }, ""))
        ->group("The operator's page");
}

SceneMonitor::SceneMonitor(const MonitorOptions& options,
                           osgMidair::HapticScene&,
                           const std::string&,
                           std::function<void()>)
{
    if (!options.address.empty()) throw std::runtime_error(kNotHere);
}

SceneMonitor::~SceneMonitor() = default;

void SceneMonitor::show(osg::Camera&) {}

void SceneMonitor::showNothing(const std::string&) {}

} // namespace midair::samples
