#pragma once

#include "plugin/settings/ForTests.h"

#include <string>

namespace osgMidair
{

/// Returns what the application registered for the scene's setting \a setting (solver, device,
/// hands), as the setting takes it, with commas between: "mine:, other:". Empty: nothing, or
/// another setting. From any thread.
OSGMIDAIR_FOR_TESTS std::string registeredNames(const std::string& setting);

} // namespace osgMidair
