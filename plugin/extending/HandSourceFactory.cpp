#include "engine-bridge/extending/NamedFactories.h"
#include "plugin/extending/HandSourceRegistry.h"

#include <utility>

namespace osgMidair
{

namespace
{

midair::bridge::NamedFactories<HandSourceFactory>& registry()
{
    static midair::bridge::NamedFactories<HandSourceFactory> all("hand source");
    return all;
}

} // namespace

HandSourceFactory HandSourceRegistry::find(const std::string& name)
{
    return registry().find(name);
}

std::vector<std::string> HandSourceRegistry::names()
{
    return registry().names();
}

bool registerHandSource(const std::string& name, HandSourceFactory make, std::string& error)
{
    return registry().add(
        name, std::move(make), {"none", "mouse", "openxr", "osc", "recorded"}, error);
}

} // namespace osgMidair
