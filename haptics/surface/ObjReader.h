#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Reads a Wavefront OBJ of at most 256 MiB: all its shapes as one mesh, with polygons (of at most
/// 4,096 corners) split into triangles, lines (l) and points (p) as triangles without area. Ignores
/// normals, texture coordinates and materials. Vertex colours become the intensity (mean of r, g
/// and b) if every vertex has one in 0 .. 1. Throws InputError that names the file and the line or
/// element. Problems that leave the mesh usable (a missing material file, colours out of range) go
/// to \a warnings, if given.
TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings = nullptr);

} // namespace midair::haptics
