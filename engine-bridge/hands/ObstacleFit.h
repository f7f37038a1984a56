#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/surface/TriangleMesh.h"

#include <vector>

namespace midair::bridge
{

/// Approximates \a mesh by capsules, in its frame, for computing shadows (see Obstacles.h).
///
/// The box along the mesh's principal axes, lengths a >= b >= c, is cut into at most \a most (>= 1)
/// strips along a, each about as wide as the box is thick or as \a leastWidth_m (> 0), whichever is
/// larger. Each strip that contains a part of the surface becomes a capsule as long as that part.
/// Strips under two wavelengths would let sound through, since shadows of several obstacles are
/// multiplied as if these were far apart. So plates count as leastWidth_m thick, and hollow or bent
/// shapes as filled between their ends. Returns none for a mesh without triangles.
std::vector<Capsule>
capsulesOf(const haptics::TriangleMesh& mesh, double leastWidth_m = 0.018, int most = 24);

} // namespace midair::bridge
