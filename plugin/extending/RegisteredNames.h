#pragma once

#include <osgMidair/Export>

#include <string>

namespace osgMidair
{

/// Returns what the application registered for the scene's setting \a setting (solver, device,
/// hands), as the setting takes it, with commas between: "mine:, other:". Empty: nothing, or
/// another setting. From any thread.
OSGMIDAIR_EXPORT std::string registeredNames(const std::string& setting);

} // namespace osgMidair
