#include "plugin/extending/HandSourceRegistry.h"
#include "plugin/extending/NamedFactories.h"

#include <utility>

namespace osgMidair
{

namespace
{

NamedFactories<HandSourceFactory>& registry()
{
    static NamedFactories<HandSourceFactory> all("hand source");
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
