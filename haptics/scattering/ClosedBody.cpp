#include "haptics/scattering/ClosedBody.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/surface/MeshTopology.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using Corners = std::array<Eigen::Vector3d, 3>;

Corners cornersOf(const TriangleMesh& mesh, Eigen::Index triangle)
{
    return {mesh.vertices.col(mesh.triangles(0, triangle)),
            mesh.vertices.col(mesh.triangles(1, triangle)),
            mesh.vertices.col(mesh.triangles(2, triangle))};
}

void requireClosed(const TriangleMesh& mesh)
{
    // Each edge at which two faces meet at an angle, and each that has not two, is a feature.
    constexpr double kAnyAngle = 1e-6;
    const MeshTopology topology = buildTopology(mesh, kAnyAngle, mesh.extent().maxCoeff());
    if (topology.surface != static_cast<int>(topology.triangles.size()))
        throw base::InputError("the body has lines or points; it needs faces only");
    for (const FeatureEdge& edge : topology.features)
    {
        const EdgeFace* const faces = topology.edgeFaces.data() + edge.firstFace;
        if (edge.faceCount != 2)
            throw base::InputError(
                fmt::format("the body has {}: an edge of face {} has {} face{}; it must be closed",
                            edge.faceCount < 2 ? "a hole" : "faces inside",
                            topology.triangles[static_cast<std::size_t>(faces[0].triangle)],
                            edge.faceCount,
                            edge.faceCount == 1 ? "" : "s"));
        if (faces[0].reversed == faces[1].reversed)
            throw base::InputError(
                fmt::format("the body's faces {} and {} are wound differently",
                            topology.triangles[static_cast<std::size_t>(faces[0].triangle)],
                            topology.triangles[static_cast<std::size_t>(faces[1].triangle)]));
    }
}

double volumeOf(const TriangleMesh& mesh)
{
    double volume = 0.0;
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        const Corners c = cornersOf(mesh, t);
        volume += c[0].dot(c[1].cross(c[2])) / 6.0;
    }
    return volume;
}

/// Calls \a take for pieces of \a one without an edge over \a longest_m, until it returns false.
template<typename Take>
bool divide(const Corners& one, double longest_m, const Take& take)
{
    const auto length = [&](int i) { return (one[(i + 1) % 3] - one[i]).norm(); };
    int longest = 0;
    for (const int i : {1, 2})
        if (length(i) > length(longest)) longest = i;
    if (!(length(longest) > longest_m)) return take(one);
    const Eigen::Vector3d &a = one[longest], &b = one[(longest + 1) % 3],
                          &c = one[(longest + 2) % 3];
    const Eigen::Vector3d middle = 0.5 * (a + b);
    return divide({a, middle, c}, longest_m, take) && divide({middle, b, c}, longest_m, take);
}

/// Two triangles with one centre can't be told apart by the waves on them.
void requireApart(const ClosedBody& body)
{
    std::vector<Eigen::Index> order(static_cast<std::size_t>(body.size()));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(),
              order.end(),
              [&](Eigen::Index a, Eigen::Index b)
              { return body.centres(0, a) < body.centres(0, b); });
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        const double near_m = 0.02 * std::sqrt(body.areas[order[i]]);
        for (std::size_t j = i + 1; j < order.size(); ++j)
        {
            const Eigen::Vector3d apart = body.centres.col(order[j]) - body.centres.col(order[i]);
            if (apart.x() > near_m) break;
            if (apart.norm() <= near_m)
                throw base::InputError(fmt::format(
                    "two faces of the body lie on each other at ({:.4f}, {:.4f}, {:.4f}) m",
                    body.centres(0, order[i]),
                    body.centres(1, order[i]),
                    body.centres(2, order[i])));
        }
    }
}

} // namespace

ClosedBody ClosedBody::from(const TriangleMesh& mesh, double longest_m, Eigen::Index mostElements)
{
    requireClosed(mesh);
    const double volume = volumeOf(mesh);
    if (!(std::abs(volume) > 0.0)) throw base::InputError("the body has no volume");
    std::vector<Corners> all;
    const auto take = [&](const Corners& one)
    {
        if (static_cast<Eigen::Index>(all.size()) >= mostElements)
            throw base::InputError(
                fmt::format("the body needs more than {} triangles for edges of at most {:.2f} mm",
                            mostElements,
                            1e3 * longest_m));
        all.push_back(one);
        return true;
    };
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        Corners one = cornersOf(mesh, t);
        if (volume < 0.0) std::swap(one[1], one[2]);
        divide(one, longest_m, take);
    }
    ClosedBody body;
    const auto n = static_cast<Eigen::Index>(all.size());
    body.corners.resize(3, 3 * n);
    body.centres.resize(3, n);
    body.normals.resize(3, n);
    body.areas.resize(n);
    for (Eigen::Index i = 0; i < n; ++i)
    {
        const Corners& one = all[static_cast<std::size_t>(i)];
        for (int corner = 0; corner < 3; ++corner)
            body.corners.col(3 * i + corner) = one[static_cast<std::size_t>(corner)];
        const Eigen::Vector3d twice = (one[1] - one[0]).cross(one[2] - one[0]);
        body.areas[i] = 0.5 * twice.norm();
        body.normals.col(i) = twice.normalized();
        body.centres.col(i) = (one[0] + one[1] + one[2]) / 3.0;
    }
    requireApart(body);
    return body;
}

Eigen::Index ClosedBody::count(const TriangleMesh& mesh, double longest_m, Eigen::Index most)
{
    Eigen::Index count = 0;
    const auto take = [&](const Corners&) { return ++count < most; };
    for (Eigen::Index t = 0; t < mesh.triangles.cols() && count < most; ++t)
        divide(cornersOf(mesh, t), longest_m, take);
    return count;
}

double ClosedBody::meanSide_m() const
{
    return std::sqrt(4.0 / std::sqrt(3.0) * areas.mean());
}

bool ClosedBody::isInside(const Eigen::Vector3d& point) const
{
    if ((point.array() < corners.rowwise().minCoeff().array()).any() ||
        (point.array() > corners.rowwise().maxCoeff().array()).any())
        return false;
    double angle = 0.0;
    for (Eigen::Index i = 0; i < size(); ++i)
    {
        const Eigen::Vector3d a = corners.col(3 * i) - point, b = corners.col(3 * i + 1) - point,
                              c = corners.col(3 * i + 2) - point;
        const double A = a.norm(), B = b.norm(), C = c.norm();
        angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                                  A * B * C + a.dot(b) * C + b.dot(c) * A + c.dot(a) * B);
    }
    return angle > base::kTwoPi;
}

} // namespace midair::haptics
