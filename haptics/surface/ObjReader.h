#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Reads a Wavefront OBJ of at most 256 MiB: all its shapes as one mesh, with polygons (at most
/// 4,096 corners) split into triangles, and lines (l) and points (p) as degenerate triangles.
/// Ignores normals, texture coordinates and materials. Vertex colours become the intensity (mean of
/// r, g and b); if only some vertices have one, the others are white. Throws InputError that names
/// the file and the line or element. Problems that leave the mesh usable (a face of two corners, a
/// missing material file, colours out of range) go to \a warnings, if given.
TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings = nullptr);

/// An OBJ file rewritten so that all other readers read it correctly and can add normals, textures
/// and materials: valid indices from 1, triangles, segments and points, lines under 4,096
/// characters, decimal points, a colour for each vertex or for none.
struct PlainObj
{
    std::string text;
    /// offset subtracted from the coordinates, because floats would lose digits; 0: none
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    std::vector<std::string> warnings; ///< for shapes that will feel different from what was
                                       ///< intended
    std::vector<std::string> notes;    ///< for information only
};

/// Reads as readObj() does.
PlainObj readPlainObj(const std::string& path);

} // namespace midair::haptics
