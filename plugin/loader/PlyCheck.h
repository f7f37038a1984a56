#pragma once

#include "plugin/settings/ForTests.h"

#include <string>

namespace osgMidair
{

/// What is wrong with a PLY file; empty: nothing. OSG's reader trusts the header, the lines and all
/// indices: what lies beyond may end the program at once, later or never, so that no trial tells.
OSGMIDAIR_FOR_TESTS std::string plyProblem(const std::string& file);

} // namespace osgMidair
