#pragma once

#include <string>

namespace osgMidair
{

/// Returns the names that the application registered for the setting \a setting (solver, device,
/// hands), as the setting's values, separated by commas: "mine:, other:". Empty: none, or another
/// setting. From any thread.
std::string registeredNames(const std::string& setting);

} // namespace osgMidair
