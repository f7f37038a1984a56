#include "engine-bridge/hands/ObstacleFit.h"

#include "haptics/base/SmallMatrices.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace midair::bridge
{

namespace
{

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Half the least extent of an obstacle, m: far below any wavelength, and over 0.
constexpr double kThinnest_m = 1e-4;

/// The principal axes of the surface as columns, the largest spread first.
Matrix3d principalAxes(const haptics::TriangleMesh& mesh, Vector3d& middle)
{
    // Moments of the surface instead of the vertices, which may crowd: the second moments of a
    // triangle about the origin are A/12 (sum v_i v_i^T + 9 m m^T), with m the mean of its corners
    // v_i.
    Matrix3d moments = Matrix3d::Zero();
    Vector3d first = Vector3d::Zero();
    double area = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        const Vector3d a = mesh.vertices.col(t[0]);
        const Vector3d b = mesh.vertices.col(t[1]);
        const Vector3d c = mesh.vertices.col(t[2]);
        const double size = 0.5 * (b - a).cross(c - a).norm();
        const Vector3d mean = (a + b + c) / 3.0;
        if (!std::isfinite(size)) continue;
        moments += size / 12.0 *
                   (a * a.transpose() + b * b.transpose() + c * c.transpose() +
                    9.0 * mean * mean.transpose());
        first += size * mean;
        area += size;
    }
    if (!(area > 0.0)) return Matrix3d::Identity();
    middle = first / area;
    const Matrix3d spread = moments / area - middle * middle.transpose();
    return base::symmetricAxes(spread).vectors.rowwise().reverse();
}

/// An interval, empty at first.
struct Range
{
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void add(double value)
    {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

Range within(const Eigen::Matrix3Xd& vertices,
             const Eigen::Matrix3Xi& triangles,
             double low,
             double high)
{
    Range range;
    for (const auto& t : triangles.colwise())
        for (int k = 0; k < 3; ++k)
        {
            const Vector3d a = vertices.col(t[k]);
            const Vector3d b = vertices.col(t[(k + 1) % 3]);
            if (a.y() >= low && a.y() <= high) range.add(a.x());
            // The points where the edge crosses the strip's borders.
            for (const double border : {low, high})
                if ((a.y() - border) * (b.y() - border) < 0.0)
                    range.add(a.x() + (b.x() - a.x()) * (border - a.y()) / (b.y() - a.y()));
        }
    return range;
}

} // namespace

std::vector<Capsule> capsulesOf(const haptics::TriangleMesh& mesh, double leastWidth_m, int most)
{
    std::vector<Capsule> capsules;
    if (mesh.triangles.cols() == 0 || !mesh.vertices.allFinite()) return capsules;
    Vector3d middle = Vector3d::Zero();
    Matrix3d axes = principalAxes(mesh, middle);
    Eigen::Matrix3Xd local = axes.transpose() * (mesh.vertices.colwise() - middle);
    Vector3d extent = local.rowwise().maxCoeff() - local.rowwise().minCoeff();
    // Sorts the axes again, since their extents may rank differently from their spreads.
    Eigen::Vector3i order(0, 1, 2);
    std::stable_sort(
        order.data(), order.data() + 3, [&](int i, int k) { return extent[i] > extent[k]; });
    Matrix3d ranked;
    for (int k = 0; k < 3; ++k)
        ranked.col(k) = axes.col(order[k]);
    axes = ranked;
    local = axes.transpose() * (mesh.vertices.colwise() - middle);
    const Vector3d low = local.rowwise().minCoeff();
    extent = (local.rowwise().maxCoeff() - low).cwiseMax(2.0 * kThinnest_m);

    const double wanted = std::floor(extent.y() / std::max(extent.z(), leastWidth_m) + 0.5);
    const int strips = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(most)));
    const double width = extent.y() / strips;
    // A single capsule is as wide as the mesh looks from its sides, on average.
    const double radius = strips > 1 ? 0.5 * width : 0.25 * (width + extent.z());
    for (int i = 0; i < strips; ++i)
    {
        const double from = low.y() + width * i;
        const Range range = within(local, mesh.triangles, from, from + width);
        if (!(range.high >= range.low)) continue;
        const double y = from + 0.5 * width;
        const double z = low.z() + 0.5 * extent.z();
        const double inset = std::min(radius, 0.5 * (range.high - range.low));
        capsules.push_back({middle + axes * Vector3d(range.low + inset, y, z),
                            middle + axes * Vector3d(range.high - inset, y, z),
                            radius});
    }
    return capsules;
}

} // namespace midair::bridge
