#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace midair::haptics
{

/// An edge that is felt as one: a crease, a boundary, or where more than two faces meet.
struct FeatureEdge
{
    int from = 0; ///< welded vertices
    int to = 0;
    int firstFace = 0; ///< its faces are edgeFaces[firstFace .. firstFace + faceCount)
    int faceCount = 0;
};

/// A face at a feature edge.
struct EdgeFace
{
    int triangle = 0;      ///< index into MeshTopology::triangles
    int corner = 0;        ///< the edge runs from this corner to the next one
    bool reversed = false; ///< this corner is FeatureEdge::to
    double sign = 1.0;     ///< -1 where the face is wound against the edge's first one
};

/// What sampling needs to know of a mesh's shape: its doubled vertices are joined, triangles
/// without area are left out, and feature edges are found.
struct MeshTopology
{
    std::vector<int> weld;      ///< mesh vertex -> welded vertex, -1 where no triangle uses it
    int vertexCount = 0;        ///< welded vertices
    std::vector<int> triangles; ///< indices of the mesh's triangles that have an area
    std::vector<std::array<int, 3>> corners; ///< welded vertices of these
    std::vector<Eigen::Vector3d> normals;    ///< unit length, of these
    std::vector<double> areas;               ///< m^2, of these
    double area = 0.0;                       ///< m^2, their sum
    std::vector<FeatureEdge> features;
    std::vector<EdgeFace> edgeFaces;
    double featureLength = 0.0; ///< m
    /// rad, one for each welded vertex: what the angles of its faces lack to 2 pi (to pi on a
    /// boundary); 0 where no feature edge ends and the surface turns by less than half the crease
    /// angle.
    std::vector<double> deficit;
    /// vertexCount + 1; the corners around a vertex are fan[fanStart[v] .. fanStart[v + 1]).
    std::vector<int> fanStart;
    std::vector<int> fan;        ///< 3 * (index into triangles) + corner
    std::vector<char> onFeature; ///< a welded vertex each: a feature edge ends at it

    bool hasFeature(int vertex) const { return onFeature[static_cast<std::size_t>(vertex)] != 0; }
};

/// Throws InputError for NaN vertices (naming the first), indices out of range and a mesh without
/// area. Vertices nearer to each other than the rounding of single precision, than a thousandth of
/// \a spacing_m and than a tenth of their shortest edge, are one. Throws Stopped where \a stop asks
/// for it.
MeshTopology buildTopology(const TriangleMesh& mesh,
                           double creaseAngle_rad,
                           double spacing_m,
                           const base::StopToken& stop = {});

/// The angle of a triangle at its first corner, 0 .. pi.
double cornerAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

} // namespace midair::haptics
