#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// The phases that a microphone at one unknown place heard.
struct HeardPhases
{
    Eigen::Matrix3Xd positions; ///< 3 x n, of the transducers, metres
    Eigen::VectorXd phase_rad;  ///< n, arg y
    double wavenumber = 0.0;    ///< k, rad/m
};

/// A place, how well the doubled phases agree there, and the phase that they agree on.
struct FoundPlace
{
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    /// |mean of e^{2j (arg y + k R)}|, 0 .. 1: of a spread s e^{-2 s^2}
    double agreement = 0.0;
    double phase_rad = 0.0; ///< half the argument of that mean
    int starts = 0;         ///< that were tried
};

/// Returns \a angle less the nearest multiple of pi: -pi/2 .. pi/2.
double wrappedToHalfTurn(double angle_rad);

/// Finds the place within \a search_m of \a planned where the doubled phases agree best.
FoundPlace findPlace(const HeardPhases& heard, const Eigen::Vector3d& planned, double search_m);

} // namespace midair::haptics
