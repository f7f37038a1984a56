#pragma once

#include <string>

namespace osgMidair
{

/// Returns the error in a PLY file; empty: none. OSG's reader trusts the header, the lines and all
/// indices: reading beyond may crash at once, later or never, so a trial can't detect it.
std::string plyProblem(const std::string& file);

} // namespace osgMidair
