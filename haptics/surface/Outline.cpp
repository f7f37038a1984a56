#include "haptics/surface/Outline.h"

#include "haptics/base/InputError.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Returns the feature edges at each vertex.
PackedLists collectEdgeFans(const MeshTopology& topology)
{
    const auto eachEnd = [&](const auto& add)
    {
        for (std::size_t e = 0; e < topology.features.size(); ++e)
            for (const int v : {topology.features[e].from, topology.features[e].to})
                add(v, static_cast<int>(e));
    };
    return {topology.vertexCount, eachEnd};
}

Eigen::Vector3d vertexPosition(const TriangleMesh& mesh, const MeshTopology& topology, int vertex)
{
    const int fan =
        topology.fan[static_cast<std::size_t>(topology.fanStart[static_cast<std::size_t>(vertex)])];
    return mesh.vertices.col(
        mesh.triangles(fan % 3, topology.triangles[static_cast<std::size_t>(fan / 3)]));
}

int otherEnd(const FeatureEdge& edge, int v)
{
    return edge.from == v ? edge.to : edge.from;
}

bool isCorner(const TriangleMesh& mesh,
              const MeshTopology& topology,
              const PackedLists& fans,
              int v,
              double creaseAngle_rad)
{
    const int degree = fans.count(v);
    if (degree == 0)
    {
        // A cone whose sides turn by the crease angle at its tip has this angle deficit.
        const double threshold = base::kTwoPi * (1.0 - std::cos(0.5 * creaseAngle_rad));
        return topology.deficit[static_cast<std::size_t>(v)] > threshold;
    }
    if (degree != 2) return true;
    const Eigen::Vector3d here = vertexPosition(mesh, topology, v);
    const auto& features = topology.features;
    const int a = otherEnd(features[static_cast<std::size_t>(fans.at(v, 0))], v);
    const int b = otherEnd(features[static_cast<std::size_t>(fans.at(v, 1))], v);
    const double inside =
        cornerAngle(here, vertexPosition(mesh, topology, a), vertexPosition(mesh, topology, b));
    return base::kPi - inside > creaseAngle_rad;
}

/// Follows unused edges from \a start to the next corner, or back to the start.
FeatureChain walk(const TriangleMesh& mesh,
                  const MeshTopology& topology,
                  const PackedLists& fans,
                  const std::vector<char>& cornerAt,
                  int start,
                  int firstEdge,
                  std::vector<char>& used)
{
    FeatureChain chain;
    chain.arc.push_back(0.0);
    int v = start;
    int e = firstEdge;
    while (e >= 0)
    {
        used[static_cast<std::size_t>(e)] = 1;
        const FeatureEdge& edge = topology.features[static_cast<std::size_t>(e)];
        const int next = otherEnd(edge, v);
        chain.steps.push_back({e, edge.from != v});
        chain.arc.push_back(
            chain.arc.back() +
            (vertexPosition(mesh, topology, next) - vertexPosition(mesh, topology, v)).norm());
        v = next;
        e = -1;
        if (cornerAt[static_cast<std::size_t>(v)] != 0) break;
        for (int i = 0; i < fans.count(v); ++i)
        {
            if (used[static_cast<std::size_t>(fans.at(v, i))] == 0) e = fans.at(v, i);
        }
    }
    chain.closed = v == start && cornerAt[static_cast<std::size_t>(v)] == 0;
    return chain;
}

constexpr double kMostPoints = 100000;

} // namespace

std::vector<int>
findCorners(const TriangleMesh& mesh, const MeshTopology& topology, double creaseAngle_rad)
{
    const PackedLists fans = collectEdgeFans(topology);
    std::vector<int> corners;
    for (int v = 0; v < topology.vertexCount; ++v)
    {
        const auto index = static_cast<std::size_t>(v);
        if (topology.fanStart[index] == topology.fanStart[index + 1]) continue;
        if (isCorner(mesh, topology, fans, v, creaseAngle_rad)) corners.push_back(v);
    }
    std::stable_sort(corners.begin(),
                     corners.end(),
                     [&](int a, int b)
                     {
                         return topology.deficit[static_cast<std::size_t>(a)] >
                                topology.deficit[static_cast<std::size_t>(b)];
                     });
    return corners;
}

std::vector<FeatureChain> chainFeatures(const TriangleMesh& mesh,
                                        const MeshTopology& topology,
                                        const std::vector<int>& corners)
{
    const PackedLists fans = collectEdgeFans(topology);
    std::vector<char> cornerAt(static_cast<std::size_t>(topology.vertexCount), 0);
    for (const int v : corners)
        cornerAt[static_cast<std::size_t>(v)] = 1;
    std::vector<char> used(topology.features.size(), 0);
    std::vector<FeatureChain> chains;
    for (const int v : corners)
    {
        for (int i = 0; i < fans.count(v); ++i)
        {
            const int e = fans.at(v, i);
            if (used[static_cast<std::size_t>(e)] != 0) continue;
            chains.push_back(walk(mesh, topology, fans, cornerAt, v, e, used));
        }
    }
    for (std::size_t e = 0; e < used.size(); ++e)
    {
        if (used[e] != 0) continue;
        chains.push_back(walk(
            mesh, topology, fans, cornerAt, topology.features[e].from, static_cast<int>(e), used));
    }
    return chains;
}

std::vector<Outline> featureOutlines(const TriangleMesh& mesh,
                                     double creaseAngle_rad,
                                     double spacing_m,
                                     const base::StopToken& stop,
                                     int* points)
{
    const MeshTopology topology = buildTopology(mesh, creaseAngle_rad, spacing_m, stop);
    const auto atPoints = std::count(topology.onPoint.begin(), topology.onPoint.end(), 1);
    if (points) *points = static_cast<int>(atPoints);
    if (topology.features.empty() && atPoints == 0)
        throw base::InputError(
            "The mesh has no edges to follow: it is closed and smooth; sample its "
            "surface, or make the crease angle smaller");
    std::vector<Outline> outlines;
    base::StopLook look(stop);
    for (const FeatureChain& chain :
         chainFeatures(mesh, topology, findCorners(mesh, topology, creaseAngle_rad)))
    {
        look.turn();
        if (!(chain.length() > 0.0)) continue;
        Outline outline;
        outline.closed = chain.closed && chain.steps.size() > 2;
        const auto steps = static_cast<Eigen::Index>(chain.steps.size());
        outline.vertices.resize(3, outline.closed ? steps : steps + 1);
        for (Eigen::Index k = 0; k < outline.vertices.cols(); ++k)
        {
            const bool last = k == steps;
            const FeatureChain::Step& step =
                chain.steps[static_cast<std::size_t>(last ? k - 1 : k)];
            const FeatureEdge& edge = topology.features[static_cast<std::size_t>(step.edge)];
            const int vertex = step.reversed != last ? edge.to : edge.from;
            outline.vertices.col(k) = vertexPosition(mesh, topology, vertex);
        }
        outlines.push_back(outline);
    }
    return outlines;
}

double Outline::length_m() const
{
    const Eigen::Index least = closed ? 3 : 2;
    if (vertices.cols() < least)
        throw base::InputError(fmt::format("outline: {} vertices; {} one needs at least {}",
                                           vertices.cols(),
                                           closed ? "a closed" : "an open",
                                           least));
    if (!vertices.allFinite()) throw base::InputError("outline: a vertex is not finite");

    double length = 0.0;
    for (Eigen::Index k = 0; k + 1 < vertices.cols(); ++k)
        length += (vertices.col(k + 1) - vertices.col(k)).norm();
    if (closed) length += (vertices.col(0) - vertices.col(vertices.cols() - 1)).norm();
    if (!(length > 0.0)) throw base::InputError("outline: its length is 0; it must be above 0");
    return length;
}

double pointsAlong(const std::vector<Outline>& outlines, double spacing_m)
{
    double count = 0.0;
    for (const Outline& outline : outlines)
        count += std::ceil(outline.length_m() / spacing_m) + (outline.closed ? 0.0 : 1.0);
    return count;
}

Eigen::Matrix3Xd Outline::points(double spacing_m) const
{
    const double length = length_m();
    // The margin keeps rounding from adding a step to a whole number of spacings.
    const double steps = std::max(std::ceil(length / spacing_m - 1e-9), closed ? 3.0 : 1.0);
    if (!(spacing_m > 0.0) || !(steps < kMostPoints))
    {
        throw base::InputError(fmt::format(
            "outline: points {:g} m apart along {:g} m; the spacing must be above {:g} m",
            spacing_m,
            length,
            length / kMostPoints));
    }
    const auto count = static_cast<Eigen::Index>(steps);
    Eigen::Matrix3Xd result(3, closed ? count : count + 1);
    Eigen::Index edge = 0;
    double start = 0.0; // start of the edge along the polyline
    const auto end = [&](Eigen::Index k) { return vertices.col((k + 1) % vertices.cols()); };
    const Eigen::Index lastEdge = vertices.cols() - (closed ? 1 : 2);
    for (Eigen::Index k = 0; k < result.cols(); ++k)
    {
        const double place = length * static_cast<double>(k) / static_cast<double>(count);
        double edgeLength = (end(edge) - vertices.col(edge)).norm();
        while (edge < lastEdge && place > start + edgeLength)
        {
            start += edgeLength;
            ++edge;
            edgeLength = (end(edge) - vertices.col(edge)).norm();
        }
        const double share =
            edgeLength > 0.0 ? std::clamp((place - start) / edgeLength, 0.0, 1.0) : 0.0;
        result.col(k) = vertices.col(edge) + share * (end(edge) - vertices.col(edge));
    }
    return result;
}

Outline Outline::circle(const Eigen::Vector3d& centre,
                        double diameter_m,
                        const Eigen::Vector3d& axis,
                        int corners)
{
    const Eigen::Quaterniond turn = base::turnBetween(Eigen::Vector3d::UnitY(), axis);
    Outline result;
    result.closed = true;
    result.vertices.resize(3, corners);
    for (int k = 0; k < corners; ++k)
    {
        const double angle = base::kTwoPi * k / corners;
        result.vertices.col(k) =
            centre +
            turn * (0.5 * diameter_m * Eigen::Vector3d(std::cos(angle), 0.0, std::sin(angle)));
    }
    return result;
}

Outline Outline::line(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
    Outline result;
    result.vertices.resize(3, 2);
    result.vertices << from, to;
    return result;
}

} // namespace midair::haptics
