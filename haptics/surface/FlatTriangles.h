#pragma once

#include "haptics/surface/MeshTopology.h"

#include <vector>

namespace midair::haptics
{

/// Adds the triangles \a flat, which have no area, to \a topology, whose triangles with an area are
/// complete, as the lines and points that they are: a line along the longest edge, a point where
/// all corners are welded to one. Those that are an edge or a corner of a triangle with an area are
/// left out, as they are felt with it (the slivers at the poles of a sphere).
void addLinesAndPoints(const TriangleMesh& mesh,
                       const std::vector<int>& flat,
                       const base::StopToken& stop,
                       MeshTopology& topology);

} // namespace midair::haptics
