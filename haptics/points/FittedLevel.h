#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

/// How well pressures y (n, Pa) fit targets a (n, in any unit, all above 0): every figure of the
/// kit is made of these.
namespace midair::haptics
{

/// s = (y.a)/(a.a): the level at which s a is nearest to y in the sense of least squares; Pa at a_l
/// = 1. In the precision of the vectors. Not finite where all targets are 0.
template<typename Achieved, typename Targets>
typename Achieved::Scalar fittedLevel(const Eigen::MatrixBase<Achieved>& y,
                                      const Eigen::MatrixBase<Targets>& a)
{
    return y.dot(a) / a.squaredNorm();
}

/// sqrt(mean((y_l/(s a_l) - 1)^2)), in the precision of the vectors; s > 0.
template<typename Achieved, typename Targets>
typename Achieved::Scalar relativeRms(const Eigen::MatrixBase<Achieved>& y,
                                      const Eigen::MatrixBase<Targets>& a,
                                      typename Achieved::Scalar s)
{
    using Scalar = typename Achieved::Scalar;
    return std::sqrt((y.array() / (s * a.array()) - Scalar(1)).square().mean());
}

/// A point falls short if it misses a target in Pa by more than this share of it.
constexpr double kShortBy = 0.01;

/// Relative errors e_l = y_l/(s a_l) - 1.
struct RelativeErrors
{
    double rms = 0.0; ///< sqrt(mean(e_l^2))
    double max = 0.0; ///< the largest |e_l|
};

/// The errors at the level \a s > 0, summed in double and in the points' order: the same to the
/// last bit for the same pressures, whatever instruction set Eigen was compiled for.
template<typename Achieved, typename Targets>
RelativeErrors
relativeErrors(const Eigen::MatrixBase<Achieved>& y, const Eigen::MatrixBase<Targets>& a, double s)
{
    RelativeErrors errors;
    double squares = 0.0;
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        const double error = y[l] / (s * a[l]) - 1.0;
        squares += error * error;
        errors.max = std::max(errors.max, std::fabs(error));
    }
    errors.rms = std::sqrt(squares / static_cast<double>(a.size()));
    return errors;
}

/// fittedLevel(), summed in double and in the points' order.
template<typename Achieved, typename Targets>
double fittedLevelInOrder(const Eigen::MatrixBase<Achieved>& y, const Eigen::MatrixBase<Targets>& a)
{
    double ya = 0.0, aa = 0.0;
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        ya += static_cast<double>(y[l]) * a[l];
        aa += static_cast<double>(a[l]) * a[l];
    }
    return ya / aa;
}

} // namespace midair::haptics
