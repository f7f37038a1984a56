#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/surface/TriangleMesh.h"

#include <vector>

namespace midair::bridge
{

/// Capsules that fill about the space that \a mesh takes up, in its frame: what shadows are
/// reckoned with (see Obstacles.h).
///
/// The box along the mesh's principal axes, lengths a >= b >= c, is cut into strips along a, each
/// about as wide as the box is thick, but not under \a leastWidth_m (> 0) and not more than \a most
/// (>= 1); each strip that holds some of the surface becomes a capsule as long as that is. Strips
/// under two wavelengths would let sound through: shadows of several obstacles are multiplied, as
/// if they were far apart. So plates count as leastWidth_m thick; what is hollow or bent counts as
/// filled between its ends. None for a mesh without triangles.
std::vector<Capsule>
capsulesOf(const haptics::TriangleMesh& mesh, double leastWidth_m = 0.018, int most = 24);

} // namespace midair::bridge
