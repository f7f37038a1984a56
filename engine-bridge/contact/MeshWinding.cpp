#include "engine-bridge/contact/MeshWinding.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace midair::bridge
{

namespace
{

using Place = std::array<double, 3>;

constexpr double kSame_m = 1e-9; ///< places that round to the same multiples are one

/// Numbers the places of the vertices, so that vertices doubled at seams become one.
std::vector<int> welded(const Eigen::Matrix3Xd& vertices)
{
    std::vector<int> order(static_cast<std::size_t>(vertices.cols()));
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = static_cast<int>(i);
    const auto rounded = [&](int axis, int v) { return std::round(vertices(axis, v) / kSame_m); };
    const auto place = [&](int v) { return Place{rounded(0, v), rounded(1, v), rounded(2, v)}; };
    const auto isFinite = [&](int v) { return vertices.col(v).allFinite(); };
    order.erase(std::partition(order.begin(), order.end(), isFinite), order.end());
    std::sort(order.begin(), order.end(), [&](int a, int b) { return place(a) < place(b); });
    std::vector<int> weld(static_cast<std::size_t>(vertices.cols()), -1);
    int last = -1;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        if (i == 0 || place(order[i]) != place(order[i - 1])) last = order[i];
        weld[static_cast<std::size_t>(order[i])] = last;
    }
    return weld;
}

} // namespace

int windingOf(const haptics::TriangleMesh& mesh)
{
    const std::vector<int> weld = welded(mesh.vertices);
    std::vector<std::pair<int, int>> edges; // as the triangles go round
    double volume = 0.0;                    // six times
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        const Eigen::Vector3i index = mesh.triangles.col(t);
        if (index.minCoeff() < 0 || index.maxCoeff() >= mesh.vertices.cols()) continue;
        std::array<int, 3> corner{};
        for (int k = 0; k < 3; ++k)
            corner[static_cast<std::size_t>(k)] = weld[static_cast<std::size_t>(index[k])];
        const bool isFlat = corner[0] == corner[1] || corner[1] == corner[2] ||
                            corner[2] == corner[0] ||
                            *std::min_element(corner.begin(), corner.end()) < 0;
        if (isFlat) continue;
        for (std::size_t k = 0; k < 3; ++k)
            edges.emplace_back(corner[k], corner[(k + 1) % 3]);
        const Eigen::Vector3d base = mesh.vertices.col(corner[0]);
        volume += base.dot(Eigen::Vector3d(mesh.vertices.col(corner[1]))
                               .cross(Eigen::Vector3d(mesh.vertices.col(corner[2]))));
    }
    if (edges.empty()) return 0;
    std::sort(edges.begin(), edges.end());
    if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return 0;
    for (const auto& [from, to] : edges)
        if (!std::binary_search(edges.begin(), edges.end(), std::pair(to, from))) return 0;
    return volume > 0.0 ? 1 : volume < 0.0 ? -1 : 0;
}

} // namespace midair::bridge
