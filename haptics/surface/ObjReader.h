#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Reads a Wavefront OBJ: all its shapes as one mesh, polygons triangulated; normals, texture
/// coordinates and materials are not needed and not looked at. Colours behind the vertices become
/// the intensity (mean of r, g and b) if every vertex has one in 0 .. 1. Throws InputError naming
/// the file and the line or element; what can be done without (a missing material file, colours out
/// of range) is told in \a warnings, if given.
TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings = nullptr);

} // namespace midair::haptics
