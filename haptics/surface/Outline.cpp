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

constexpr double kMostPoints = 100000;

} // namespace

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
    double start = 0.0; // position of the edge's start along the polyline
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
