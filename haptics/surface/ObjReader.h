#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Reads a Wavefront OBJ of at most 256 MiB: all its shapes as one mesh, with polygons (of at most
/// 4,096 corners) cut into triangles. Normals, texture coordinates and materials are ignored.
/// Colours behind the vertices become the intensity (mean of r, g and b) if every vertex has one in
/// 0 .. 1. Throws InputError that names the file and the line or element. What the mesh can do
/// without (a missing material file, colours out of range) is told in \a warnings, if given.
TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings = nullptr);

} // namespace midair::haptics
