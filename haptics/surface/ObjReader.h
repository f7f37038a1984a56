#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Reads a Wavefront OBJ of at most 256 MiB: all its shapes as one mesh, with polygons (of at most
/// 4,096 corners) split into triangles, lines (l) and points (p) as triangles without area. Ignores
/// normals, texture coordinates and materials. Vertex colours become the intensity (mean of r, g
/// and b); where only some vertices have one, the others are white. Throws InputError that names
/// the file and the line or element. Problems that leave the mesh usable (a face of two corners, a
/// missing material file, colours out of range) go to \a warnings, if given.
TriangleMesh readObj(const std::string& path, std::vector<std::string>* warnings = nullptr);

/// An OBJ file in words that no other reader gets wrong, so that one may dress it with normals,
/// textures and materials: indices from 1 that are there, triangles, segments and points, lines
/// under 4,096 characters, the point as decimal sign, a colour for each vertex or for none.
struct PlainObj
{
    std::string text;
    /// what was taken off the coordinates, as floats would lose their digits; 0: nothing
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    std::vector<std::string> warnings; ///< of what is felt otherwise than it was meant
    std::vector<std::string> notes;    ///< of what is only worth knowing
};

/// Reads as readObj() does.
PlainObj readPlainObj(const std::string& path);

} // namespace midair::haptics
