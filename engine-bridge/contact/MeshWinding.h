#pragma once

#include "haptics/surface/TriangleMesh.h"

namespace midair::bridge
{

/// Returns on which side of its triangles a mesh has its outside: 1 where their normals (q - p) x
/// (r - p) point out, -1 where they point in, 0 where that can't be told: it is open, or its
/// windings contradict each other. Vertices at equal places (to a nanometre) count as one;
/// triangles without area or with places that aren't finite are left out.
int windingOf(const haptics::TriangleMesh& mesh);

} // namespace midair::bridge
