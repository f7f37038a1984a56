#pragma once

#include <osgMidair/HandSourceFactory>

#include <string>
#include <vector>

namespace osgMidair
{

/// The hand sources that the application registered. From any thread.
struct HandSourceRegistry
{
    /// Returns what makes the source \a name; empty if none of that name was registered.
    static HandSourceFactory find(const std::string& name);
    static std::vector<std::string> names();
};

} // namespace osgMidair
