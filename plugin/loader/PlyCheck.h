#pragma once

#include <string>

namespace osgMidair
{

/// What is wrong with a PLY file; empty: nothing. OSG's reader trusts the header, the lines and all
/// indices: what lies beyond may end the program at once, later or never, so that no trial tells.
std::string plyProblem(const std::string& file);

} // namespace osgMidair
