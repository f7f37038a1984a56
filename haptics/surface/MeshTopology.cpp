#include "haptics/surface/MeshTopology.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/Units.h"
#include "haptics/surface/PointGrid.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using Edge = std::pair<int, int>; ///< welded vertices, the lower first

Edge edgeOf(int a, int b)
{
    return {std::min(a, b), std::max(a, b)};
}

/// Vertices and edges shared by triangles with and without an area.
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

/// Adds the degenerate triangles \a flat to \a topology, whose triangles with an area are complete,
/// as lines and points: a line along the longest edge, a point if all corners are welded to one.
/// Leaves out those that are an edge or a corner of a triangle with an area, because they are felt
/// with it (the slivers at the poles of a sphere).
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
        // -1: unused corner
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

/// Limit of coordinates (m), beyond every model; keeps squares and cell indices far from overflow.
constexpr double kLargestCoordinate_m = 1e9;

/// Throws InputError for vertices and indices that cannot be used.
void checkMesh(const TriangleMesh& mesh)
{
    const Eigen::Index vertices = mesh.vertices.cols();
    if (mesh.triangles.cols() == 0) throw base::InputError("The mesh has no triangles");
    if (mesh.triangles.cols() > base::kMostTriangles)
        throw base::InputError(fmt::format("The mesh has {} triangles; there must be at most {}",
                                           mesh.triangles.cols(),
                                           base::kMostTriangles));
    for (Eigen::Index v = 0; v < vertices; ++v)
    {
        if (!mesh.vertices.col(v).allFinite())
            throw base::InputError(fmt::format("Vertex {} of the mesh is not finite", v));
    }
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        for (const int v : mesh.triangles.col(t))
        {
            if (v < 0 || v >= vertices)
            {
                throw base::InputError(fmt::format(
                    "Triangle {} of the mesh refers to vertex {}; there are {}", t, v, vertices));
            }
            if (mesh.vertices.col(v).cwiseAbs().maxCoeff() > kLargestCoordinate_m)
                throw base::InputError(
                    fmt::format("Vertex {} of the mesh is farther than 1e9 m from the origin", v));
        }
    }
    if (mesh.intensity.size() != 0 && mesh.intensity.size() != vertices)
        throw base::InputError(fmt::format(
            "The mesh has {} intensities for {} vertices", mesh.intensity.size(), vertices));
    if (mesh.paint &&
        (mesh.paint->coordinates.cols() != vertices ||
         static_cast<Eigen::Index>(mesh.paint->image.size()) != mesh.triangles.cols()))
    {
        throw base::InputError(
            fmt::format("The mesh's paint is for {} vertices and {} triangles; there are {} and {}",
                        mesh.paint->coordinates.cols(),
                        mesh.paint->image.size(),
                        vertices,
                        mesh.triangles.cols()));
    }
}

/// Returns the shortest non-zero edge at each vertex, m; infinite if there is none.
std::vector<double> shortestEdges(const TriangleMesh& mesh)
{
    std::vector<double> shortest2(static_cast<std::size_t>(mesh.vertices.cols()),
                                  std::numeric_limits<double>::infinity());
    for (const auto& t : mesh.triangles.colwise())
    {
        for (int k = 0; k < 3; ++k)
        {
            const int a = t[k];
            const int b = t[(k + 1) % 3];
            const double length2 = (mesh.vertices.col(a) - mesh.vertices.col(b)).squaredNorm();
            if (!(length2 > 0.0)) continue;
            double& atA = shortest2[static_cast<std::size_t>(a)];
            double& atB = shortest2[static_cast<std::size_t>(b)];
            atA = std::min(atA, length2);
            atB = std::min(atB, length2);
        }
    }
    for (double& value : shortest2)
        value = std::sqrt(value);
    return shortest2;
}

void weldVertices(const TriangleMesh& mesh,
                  double spacing_m,
                  const base::StopToken& stop,
                  MeshTopology& topology)
{
    topology.weld.assign(static_cast<std::size_t>(mesh.vertices.cols()), -1);
    double largest = 0x1p-900; // above 0, for a mesh with all vertices at the origin
    for (const int v : mesh.triangles.reshaped())
        largest = std::max(largest, mesh.vertices.col(v).cwiseAbs().maxCoeff());
    // Four units in the last place of a float, because seam coordinates that a program wrote twice
    // may differ by that. Never so small that cell indices overflow.
    const double tolerance =
        std::min(0x1p-22 * largest, std::max(1e-3 * spacing_m, 0x1p-40 * largest));
    // Welding tolerance over the shortest edge: keeps small triangles from collapsing.
    constexpr double kOfEdge = 0.1;
    const std::vector<double> shortest = shortestEdges(mesh);
    PointGrid grid(8.0 * tolerance);
    grid.reserve(static_cast<std::size_t>(mesh.vertices.cols()));
    // If all vertices are in one cell of the grid, a single search takes milliseconds.
    base::StopLook look(stop, 16);
    for (const int v : mesh.triangles.reshaped())
    {
        look.turn();
        int& welded = topology.weld[static_cast<std::size_t>(v)];
        if (welded >= 0) continue;
        const Eigen::Vector3d point = mesh.vertices.col(v);
        const double edge = shortest[static_cast<std::size_t>(v)];
        welded = grid.nearest(point, std::min(tolerance, kOfEdge * edge));
        if (welded < 0) welded = grid.insert(point);
    }
    topology.vertexCount = grid.size();
}

void collectTriangles(const TriangleMesh& mesh, const base::StopToken& stop, MeshTopology& topology)
{
    // The normal of a triangle flatter than this, height over length, is rounding noise.
    constexpr double kFlatness = 1e-10;
    const Eigen::Index count = mesh.triangles.cols();
    topology.triangles.reserve(static_cast<std::size_t>(count));
    topology.corners.reserve(static_cast<std::size_t>(count));
    topology.normals.reserve(static_cast<std::size_t>(count));
    topology.areas.reserve(static_cast<std::size_t>(count));
    std::vector<int> flat;
    base::StopLook look(stop);
    for (Eigen::Index t = 0; t < count; ++t)
    {
        look.turn();
        const Eigen::Vector3i v = mesh.triangles.col(t);
        const std::array<int, 3> welded = {topology.weld[static_cast<std::size_t>(v[0])],
                                           topology.weld[static_cast<std::size_t>(v[1])],
                                           topology.weld[static_cast<std::size_t>(v[2])]};
        const bool merged =
            welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0];
        const Eigen::Vector3d a = mesh.vertices.col(v[0]);
        const Eigen::Vector3d ab = mesh.vertices.col(v[1]) - a;
        const Eigen::Vector3d ac = mesh.vertices.col(v[2]) - a;
        const Eigen::Vector3d cross = ab.cross(ac);
        const double twice = cross.norm();
        const double longest2 =
            std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
        if (merged || !(twice > kFlatness * longest2))
        {
            flat.push_back(static_cast<int>(t));
            continue;
        }
        topology.triangles.push_back(static_cast<int>(t));
        topology.corners.push_back(welded);
        topology.normals.emplace_back(cross / twice);
        topology.areas.push_back(0.5 * twice);
        topology.area += 0.5 * twice;
    }
    topology.surface = static_cast<int>(topology.triangles.size());
    addLinesAndPoints(mesh, flat, stop, topology);
}

/// Collects the triangles' corners around each vertex.
void collectFans(MeshTopology& topology)
{
    const auto eachCorner = [&](const auto& add)
    {
        for (std::size_t t = 0; t < topology.corners.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                if (topology.corners[t][k] >= 0)
                    add(topology.corners[t][k], static_cast<int>(3 * t + k));
    };
    PackedLists fans(topology.vertexCount, eachCorner);
    topology.fanStart = std::move(fans.start);
    topology.fan = std::move(fans.all);
}

/// An edge of one triangle.
struct HalfEdge
{
    int low, high; ///< welded vertices
    int corner;    ///< 3 * triangle + corner at which it starts
};

/// Returns true if the edge with the faces [begin, end) is a feature.
bool isFeature(const MeshTopology& topology,
               const std::vector<HalfEdge>& halves,
               std::size_t begin,
               std::size_t end,
               double cosCrease)
{
    const auto apex = [&](const HalfEdge& half)
    {
        return topology.corners[static_cast<std::size_t>(half.corner / 3)]
                               [static_cast<std::size_t>((half.corner % 3 + 2) % 3)];
    };
    // Duplicate faces count once; otherwise all edges of a doubled sheet would be features.
    std::size_t second = end;
    for (std::size_t i = begin + 1; i < end; ++i)
    {
        if (apex(halves[i]) == apex(halves[begin])) continue;
        if (second == end)
        {
            second = i;
        }
        else if (apex(halves[i]) != apex(halves[second]))
        {
            return true; // three faces or more
        }
    }
    if (second == end) return true; // boundary
    const auto start = [&](const HalfEdge& half)
    {
        return topology.corners[static_cast<std::size_t>(half.corner / 3)]
                               [static_cast<std::size_t>(half.corner % 3)];
    };
    const double sign = start(halves[begin]) == start(halves[second]) ? -1.0 : 1.0;
    const double cosTurn =
        sign * topology.normals[static_cast<std::size_t>(halves[begin].corner / 3)].dot(
                   topology.normals[static_cast<std::size_t>(halves[second].corner / 3)]);
    return cosTurn < cosCrease;
}

void addFeature(const TriangleMesh& mesh,
                MeshTopology& topology,
                const std::vector<HalfEdge>& halves,
                std::size_t begin,
                std::size_t end)
{
    FeatureEdge edge;
    edge.from = halves[begin].low;
    edge.to = halves[begin].high;
    edge.firstFace = static_cast<int>(topology.edgeFaces.size());
    edge.faceCount = static_cast<int>(end - begin);
    topology.onFeature[static_cast<std::size_t>(edge.from)] = 1;
    topology.onFeature[static_cast<std::size_t>(edge.to)] = 1;
    for (std::size_t i = begin; i < end; ++i)
    {
        EdgeFace face;
        face.triangle = halves[i].corner / 3;
        face.corner = halves[i].corner % 3;
        face.reversed = topology.corners[static_cast<std::size_t>(face.triangle)]
                                        [static_cast<std::size_t>(face.corner)] != edge.from;
        const bool firstReversed =
            i == begin ? face.reversed
                       : topology.edgeFaces[static_cast<std::size_t>(edge.firstFace)].reversed;
        face.sign = i != begin && face.reversed == firstReversed ? -1.0 : 1.0;
        topology.edgeFaces.push_back(face);
    }
    const EdgeFace& face = topology.edgeFaces[static_cast<std::size_t>(edge.firstFace)];
    const int t = topology.triangles[static_cast<std::size_t>(face.triangle)];
    topology.featureLength += (mesh.vertices.col(mesh.triangles(face.corner, t)) -
                               mesh.vertices.col(mesh.triangles((face.corner + 1) % 3, t)))
                                  .norm();
    topology.features.push_back(edge);
}

/// Sorts half edges into buckets by their lower vertex: linear in the mesh's size, without hashing.
void findFeatures(const TriangleMesh& mesh,
                  double creaseAngle_rad,
                  const base::StopToken& stop,
                  MeshTopology& topology,
                  std::vector<char>& boundary)
{
    boundary.assign(static_cast<std::size_t>(topology.vertexCount), 0);
    topology.onFeature = topology.onPoint;
    const double cosCrease = std::cos(creaseAngle_rad);
    std::vector<HalfEdge> halves;
    base::StopLook look(stop);
    for (int v = 0; v < topology.vertexCount; ++v)
    {
        look.turn();
        halves.clear();
        const auto index = static_cast<std::size_t>(v);
        for (int i = topology.fanStart[index]; i < topology.fanStart[index + 1]; ++i)
        {
            const int fan = topology.fan[static_cast<std::size_t>(i)];
            const auto& corners = topology.corners[static_cast<std::size_t>(fan / 3)];
            const int k = fan % 3;
            const int next = corners[static_cast<std::size_t>((k + 1) % 3)];
            const int last = corners[static_cast<std::size_t>((k + 2) % 3)];
            if (v < next) halves.push_back({v, next, fan});
            if (v < last) halves.push_back({v, last, fan - k + (k + 2) % 3});
        }
        std::sort(halves.begin(),
                  halves.end(),
                  [](const HalfEdge& a, const HalfEdge& b)
                  { return a.high != b.high ? a.high < b.high : a.corner < b.corner; });
        for (std::size_t begin = 0; begin < halves.size();)
        {
            std::size_t end = begin + 1;
            while (end < halves.size() && halves[end].high == halves[begin].high)
                ++end;
            if (end - begin == 1)
            {
                boundary[index] = 1;
                boundary[static_cast<std::size_t>(halves[begin].high)] = 1;
            }
            if (isFeature(topology, halves, begin, end, cosCrease))
            {
                addFeature(mesh, topology, halves, begin, end);
            }
            begin = end;
        }
    }
}

/// Returns true if a face at the vertex is turned from the first one by more than half the crease
/// angle. Otherwise a vertex without features can't be a tip.
bool turns(const MeshTopology& topology, std::size_t vertex, double cosHalfCrease)
{
    const auto begin = static_cast<std::size_t>(topology.fanStart[vertex]);
    const auto end = static_cast<std::size_t>(topology.fanStart[vertex + 1]);
    for (std::size_t i = begin + 1; i < end; ++i)
    {
        const auto first = static_cast<std::size_t>(topology.fan[begin] / 3);
        const auto face = static_cast<std::size_t>(topology.fan[i] / 3);
        if (topology.normals[first].dot(topology.normals[face]) < cosHalfCrease) return true;
    }
    return false;
}

/// Measures only possible corners: the angles of all vertices would take longer than the rest of
/// this file.
void measureDeficits(const TriangleMesh& mesh,
                     const std::vector<char>& boundary,
                     double creaseAngle_rad,
                     const base::StopToken& stop,
                     MeshTopology& topology)
{
    const double cosHalfCrease = std::cos(0.5 * creaseAngle_rad);
    topology.deficit.assign(static_cast<std::size_t>(topology.vertexCount), 0.0);
    base::StopLook look(stop);
    for (std::size_t vertex = 0; vertex < topology.deficit.size(); ++vertex)
    {
        look.turn();
        if (topology.onFeature[vertex] == 0 && !turns(topology, vertex, cosHalfCrease)) continue;
        double deficit = boundary[vertex] != 0 ? base::kPi : base::kTwoPi;
        for (int i = topology.fanStart[vertex]; i < topology.fanStart[vertex + 1]; ++i)
        {
            const int fan = topology.fan[static_cast<std::size_t>(i)];
            const int k = fan % 3;
            const Eigen::Vector3i v =
                mesh.triangles.col(topology.triangles[static_cast<std::size_t>(fan / 3)]);
            deficit -= cornerAngle(mesh.vertices.col(v[k]),
                                   mesh.vertices.col(v[(k + 1) % 3]),
                                   mesh.vertices.col(v[(k + 2) % 3]));
        }
        topology.deficit[vertex] = deficit;
    }
}

} // namespace

double cornerAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    const Eigen::Vector3d ab = b - a;
    const Eigen::Vector3d ac = c - a;
    return std::atan2(ab.cross(ac).norm(), ab.dot(ac));
}

MeshTopology buildTopology(const TriangleMesh& mesh,
                           double creaseAngle_rad,
                           double spacing_m,
                           const base::StopToken& stop)
{
    checkMesh(mesh);
    stop.throwIfRequested();
    MeshTopology topology;
    weldVertices(mesh, spacing_m, stop, topology);
    collectTriangles(mesh, stop, topology);
    collectFans(topology);
    stop.throwIfRequested();
    std::vector<char> boundary;
    findFeatures(mesh, creaseAngle_rad, stop, topology, boundary);
    measureDeficits(mesh, boundary, creaseAngle_rad, stop, topology);
    return topology;
}

} // namespace midair::haptics
