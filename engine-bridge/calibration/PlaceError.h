#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <functional>

namespace midair::bridge
{

/// Returns the cross product matrix of \a v.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v);

/// Error of a measured place.
struct PlaceError
{
    double median_m = 0.0;
    double most95_m = 0.0; ///< 95 % quantile
};

/// Estimates the error of a place from seeded draws: it is normal with the covariance \a noise_m^2
/// \a C; as noise_m is estimated with \a freedom (>= 1) degrees of freedom, it has Student's tails.
PlaceError placeError(const Eigen::Matrix3d& C, double noise_m, int freedom, std::uint64_t seed);

/// Returns \a at, a covariance C as above, at the worst place on the sphere of \a radius around the
/// origin.
Eigen::Matrix3d worstAtRadius(double radius,
                              const std::function<Eigen::Matrix3d(const Eigen::Vector3d&)>& at);

} // namespace midair::bridge
