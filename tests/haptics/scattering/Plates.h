#pragma once

#include "haptics/scattering/ScatteredField.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/solvers/Solvers.h"

#include <Eigen/Core>

#include <cmath>
#include <complex>
#include <memory>

namespace midair::test
{

/// Two by two AUTD3 units, side by side, facing z, in the plane z = 0.
inline haptics::TransducerArray fourUnits()
{
    constexpr double kWidth_m = 0.1925, kHeight_m = 0.1515;
    const haptics::TransducerArray one = haptics::TransducerArray::load("autd3");
    haptics::TransducerArray four = one;
    const Eigen::Index n = one.positions.cols();
    const Eigen::Vector3d centre =
        0.5 * (one.positions.rowwise().minCoeff() + one.positions.rowwise().maxCoeff());
    four.positions.resize(3, 4 * n);
    four.normals = one.normals.replicate(1, 4);
    four.board.clear();
    for (int k = 0; k < 4; ++k)
    {
        const Eigen::Vector3d place(
            (k % 2 - 0.5) * kWidth_m, (std::floor(0.5 * k) - 0.5) * kHeight_m, 0.0);
        four.positions.middleCols(k * n, n) = one.positions.colwise() + (place - centre);
        four.board.insert(four.board.end(), static_cast<std::size_t>(n), k);
    }
    return four;
}

/// A square plate \a behind_m behind \a centre, seen from the units.
inline haptics::Reflector plateBehind(const Eigen::Vector3d& centre, double side_m, double behind_m)
{
    haptics::Reflector plate;
    plate.position = centre + Eigen::Vector3d(0.0, 0.0, behind_m);
    plate.normal = -Eigen::Vector3d::UnitZ();
    plate.along = Eigen::Vector3d::UnitX();
    plate.size_m = {side_m, side_m};
    plate.accuracy_mm = 0.1;
    return plate;
}

/// The true field of an array with a rigid plate, as far as a thin screen of 8 cells a wavelength
/// is true.
inline haptics::ScatteredField
truthOf(const haptics::Reflector& plate, const haptics::TransducerArray& free, int threads)
{
    return {{std::make_shared<haptics::ThinScreen>(
                *haptics::plateOf(plate), haptics::Medium().wavelength(free.frequency_Hz))},
            free,
            haptics::Medium(),
            threads};
}

/// Returns the pressures of \a q at \a points, Pa.
inline Eigen::VectorXcd pressuresOf(const Eigen::VectorXcf& q,
                                    const Eigen::Matrix3Xd& points,
                                    haptics::ScatteredField& truth)
{
    truth.setDrive(q);
    return truth.free_Pa(points) + truth.scattered_Pa(points);
}

/// Of \a p over its mean magnitude, minus 1: the error at points of equal targets.
inline double rmsError(const Eigen::VectorXcd& p)
{
    const Eigen::ArrayXd y = p.cwiseAbs().array();
    return std::sqrt((y / y.mean() - 1.0).square().mean());
}

/// The drive that the kit's solver finds for \a points with \a array and its reflectors.
inline Eigen::VectorXcf driveFor(const haptics::ControlPoints& points,
                                 const haptics::TransducerArray& array)
{
    Eigen::VectorXcf q;
    haptics::makeSolver("gauss-newton")->solve(points, array, haptics::Medium(), q);
    return q;
}

} // namespace midair::test
