#include "haptics/surface/FlatTriangles.h"

#include <algorithm>
#include <utility>

namespace midair::haptics
{

namespace
{

using Edge = std::pair<int, int>; ///< welded vertices, the lower first

Edge edgeOf(int a, int b)
{
    return {std::min(a, b), std::max(a, b)};
}

/// What the triangles with an area have in common with those without.
struct SurfaceParts
{
    std::vector<char> corner; ///< for each welded vertex: 1 if a triangle with an area uses it
    std::vector<Edge> edges;  ///< sorted; only those with a flat triangle at both ends
};

SurfaceParts
surfaceParts(const TriangleMesh& mesh, const std::vector<int>& flat, const MeshTopology& topology)
{
    const auto count = static_cast<std::size_t>(topology.vertexCount);
    std::vector<char> atFlat(count, 0);
    for (const int t : flat)
        for (const int v : mesh.triangles.col(t))
            atFlat[static_cast<std::size_t>(topology.weld[static_cast<std::size_t>(v)])] = 1;
    SurfaceParts parts;
    parts.corner.assign(count, 0);
    for (const auto& corners : topology.corners)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto a = static_cast<std::size_t>(corners[k]);
            const auto b = static_cast<std::size_t>(corners[(k + 1) % 3]);
            parts.corner[a] = 1;
            if (atFlat[a] != 0 && atFlat[b] != 0)
                parts.edges.push_back(edgeOf(corners[k], corners[(k + 1) % 3]));
        }
    std::sort(parts.edges.begin(), parts.edges.end());
    return parts;
}

} // namespace

void addLinesAndPoints(const TriangleMesh& mesh,
                       const std::vector<int>& flat,
                       const base::StopToken& stop,
                       MeshTopology& topology)
{
    topology.onPoint.assign(static_cast<std::size_t>(topology.vertexCount), 0);
    if (flat.empty()) return;
    const SurfaceParts surface = surfaceParts(mesh, flat, topology);
    base::StopLook look(stop);
    for (const int t : flat)
    {
        look.turn();
        const Eigen::Vector3i v = mesh.triangles.col(t);
        const auto welded = [&](Eigen::Index k)
        { return topology.weld[static_cast<std::size_t>(v[k % 3])]; };
        Eigen::Index from = -1;
        double longest2 = -1.0;
        for (Eigen::Index k = 0; k < 3; ++k)
        {
            const double length2 =
                (mesh.vertices.col(v[(k + 1) % 3]) - mesh.vertices.col(v[k])).squaredNorm();
            if (welded(k) == welded(k + 1) || length2 <= longest2) continue;
            from = k;
            longest2 = length2;
        }
        // -1: a corner that counts for nothing
        std::array<int, 3> corners = {-1, -1, -1};
        if (from < 0)
        {
            corners[0] = welded(0);
            if (surface.corner[static_cast<std::size_t>(corners[0])] != 0) continue;
            topology.onPoint[static_cast<std::size_t>(corners[0])] = 1;
        }
        else
        {
            if (std::binary_search(surface.edges.begin(),
                                   surface.edges.end(),
                                   edgeOf(welded(from), welded(from + 1))))
                continue;
            corners[static_cast<std::size_t>(from)] = welded(from);
            corners[static_cast<std::size_t>((from + 1) % 3)] = welded(from + 1);
        }
        topology.triangles.push_back(t);
        topology.corners.push_back(corners);
        topology.normals.emplace_back(Eigen::Vector3d::Zero());
        topology.areas.push_back(0.0);
    }
}

} // namespace midair::haptics
