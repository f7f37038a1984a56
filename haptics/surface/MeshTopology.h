#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <array>
#include <numeric>
#include <vector>

namespace midair::haptics
{

/// Feature edge: a crease, a boundary, or an edge with more than two faces.
struct FeatureEdge
{
    int from = 0; ///< welded vertices
    int to = 0;
    int firstFace = 0; ///< index; its faces are edgeFaces[firstFace .. firstFace + faceCount)
    int faceCount = 0;
};

/// A face at a feature edge.
struct EdgeFace
{
    int triangle = 0;      ///< index into MeshTopology::triangles
    int corner = 0;        ///< the edge runs from this corner to the next one
    bool reversed = false; ///< the corner is FeatureEdge::to
    double sign = 1.0;     ///< -1 if its winding is opposite to that of the edge's first face
};

/// Lists of numbers in one vector: list k is all[start[k] .. start[k + 1]).
struct PackedLists
{
    std::vector<int> start; ///< lists + 1
    std::vector<int> all;

    /// \a each is called twice, and calls add(list, number) for each number of each list, in list
    /// order.
    template<typename Each>
    PackedLists(int lists, const Each& each) : start(static_cast<std::size_t>(lists) + 1, 0)
    {
        each([this](int list, int) { ++start[static_cast<std::size_t>(list) + 1]; });
        std::partial_sum(start.begin(), start.end(), start.begin());
        all.resize(static_cast<std::size_t>(start.back()));
        std::vector<int> at(start.begin(), start.end() - 1);
        each(
            [&](int list, int number)
            {
                const int place = at[static_cast<std::size_t>(list)]++;
                all[static_cast<std::size_t>(place)] = number;
            });
    }

    int count(int list) const
    {
        return start[static_cast<std::size_t>(list) + 1] - start[static_cast<std::size_t>(list)];
    }
    int at(int list, int i) const
    {
        return all[static_cast<std::size_t>(start[static_cast<std::size_t>(list)] + i)];
    }
};

/// Topology of a mesh for sampling: duplicate vertices are welded, degenerate triangles become
/// lines and points, and feature edges, including lines, are found.
struct MeshTopology
{
    std::vector<int> weld; ///< mesh vertex -> welded vertex; -1 if no triangle uses it
    int vertexCount = 0;   ///< welded vertices
    /// indices of the mesh's triangles: first those with an area, then lines and points
    std::vector<int> triangles;
    int surface = 0; ///< number of triangles with an area
    /// welded vertices of these; -1: unused corner, because a line has two corners and a point one
    std::vector<std::array<int, 3>> corners;
    std::vector<Eigen::Vector3d> normals; ///< unit length, of these; zero for lines and points
    std::vector<double> areas;            ///< m^2, of these; 0 for lines and points
    double area = 0.0;                    ///< m^2, total
    std::vector<FeatureEdge> features;
    std::vector<EdgeFace> edgeFaces;
    double featureLength = 0.0; ///< m
    /// rad, for each welded vertex: 2 pi (pi on a boundary) minus the sum of its faces' angles; 0
    /// if no feature edge ends there and the surface turns by less than half the crease angle.
    std::vector<double> deficit;
    /// vertexCount + 1; the corners around a vertex are fan[fanStart[v] .. fanStart[v + 1]).
    std::vector<int> fanStart;
    std::vector<int> fan; ///< 3 * (index into triangles) + corner
    /// for each welded vertex: 1 if a feature edge ends at it or a point is at it
    std::vector<char> onFeature;
    std::vector<char> onPoint; ///< for each welded vertex: 1 if a point is at it

    bool hasFeature(int vertex) const { return onFeature[static_cast<std::size_t>(vertex)] != 0; }
    bool hasPoint(int vertex) const { return onPoint[static_cast<std::size_t>(vertex)] != 0; }
};

/// Builds the topology of \a mesh. Vertices are welded if they are closer than the rounding of
/// single precision, a thousandth of \a spacing_m and a tenth of their shortest edge. Throws
/// InputError for NaN vertices (naming the first), indices out of range and a mesh without
/// triangles, Stopped if \a stop requests it.
MeshTopology buildTopology(const TriangleMesh& mesh,
                           double creaseAngle_rad,
                           double spacing_m,
                           const base::StopToken& stop = {});

/// Returns the angle of a triangle at its corner \a a, 0 .. pi.
double cornerAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

} // namespace midair::haptics
