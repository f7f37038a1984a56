#include "haptics/tuning/TouchedPlate.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr Eigen::Index kFewest = 4;
constexpr double kNarrowest_m = 0.01;
constexpr double kFarthestOff_m = 6e-3;
constexpr double kLeastAccuracy_mm = 1e-3; // of an exact plane
constexpr int kTurns = 1800;               // of the rectangle, 0.05 degrees each

/// The box around \a places (2 x n) along axes turned by \a angle_rad.
Eigen::AlignedBox2d boxAt(double angle_rad, const Eigen::Matrix2Xd& places)
{
    const Eigen::Matrix2Xd turned = Eigen::Rotation2Dd(-angle_rad).toRotationMatrix() * places;
    return {turned.rowwise().minCoeff().eval(), turned.rowwise().maxCoeff().eval()};
}

} // namespace

TouchedPlate TouchedPlate::at(const Eigen::Matrix3Xd& touched, const Eigen::Vector3d& from)
{
    if (touched.cols() < kFewest)
        throw base::InputError(
            fmt::format("{} places were touched; a plate needs its four corners", touched.cols()));
    if (!touched.allFinite()) throw base::InputError("a touched place isn't finite");
    const Eigen::Vector3d middle = touched.rowwise().mean();
    const Eigen::JacobiSVD<Eigen::Matrix3Xd> svd(touched.colwise() - middle, Eigen::ComputeFullU);
    Eigen::Matrix3d axes = svd.matrixU(); // along the plane, along it, across it
    if (axes.col(2).dot(from - middle) < 0.0) axes.col(2) *= -1.0;
    axes.col(1) = axes.col(2).cross(axes.col(0));
    const Eigen::Matrix3Xd seen = axes.transpose() * (touched.colwise() - middle);
    Eigen::Index worst = 0;
    if (seen.row(2).cwiseAbs().maxCoeff(&worst) > kFarthestOff_m)
        throw base::InputError(
            fmt::format("touched place {} is {:.1f} mm off the plane of all; at most {:g} mm are "
                        "possible",
                        worst + 1,
                        1e3 * std::abs(seen(2, worst)),
                        1e3 * kFarthestOff_m));

    double angle_rad = 0.0;
    Eigen::AlignedBox2d box = boxAt(0.0, seen.topRows<2>());
    for (int turn = 1; turn < kTurns; ++turn)
    {
        const double other_rad = 0.5 * base::kPi * turn / kTurns;
        const Eigen::AlignedBox2d other = boxAt(other_rad, seen.topRows<2>());
        if (other.volume() >= box.volume()) continue;
        box = other;
        angle_rad = other_rad;
    }
    if (box.sizes().minCoeff() < kNarrowest_m)
        throw base::InputError(fmt::format("the touched places lie on a line, to {:.1f} mm",
                                           1e3 * box.sizes().minCoeff()));
    const Eigen::Rotation2Dd turned(angle_rad);
    TouchedPlate plate;
    Reflector& one = plate.reflector;
    one.position = middle + axes.leftCols<2>() * (turned * box.center());
    one.normal = axes.col(2);
    one.along = axes.leftCols<2>() * (turned * Eigen::Vector2d::UnitX());
    one.size_m = box.sizes();
    plate.off_m = std::sqrt(seen.row(2).array().square().mean());
    // Three of the places' distances are taken up by the plane.
    const auto free = static_cast<double>(touched.cols() - 3);
    one.accuracy_mm = std::max(kLeastAccuracy_mm,
                               1e3 * std::sqrt(seen.row(2).squaredNorm() / free) /
                                   std::sqrt(static_cast<double>(touched.cols())));
    return plate;
}

} // namespace midair::haptics
