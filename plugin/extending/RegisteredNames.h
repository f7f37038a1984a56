#pragma once

#include <string>

namespace osgMidair
{

/// Returns what the application registered for the scene's setting \a setting (solver, device,
/// hands), as the setting takes it, with commas between: "mine:, other:". Empty: nothing, or
/// another setting. From any thread.
std::string registeredNames(const std::string& setting);

} // namespace osgMidair
