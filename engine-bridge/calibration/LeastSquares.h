#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <functional>

namespace midair::bridge
{

/// Returns the rotation and shift of \a six: a rotation vector (rad) and a translation (m).
Eigen::Isometry3d motionOf(const Eigen::Matrix<double, 6, 1>& six);

/// Result of leastSquares().
struct LeastSquares
{
    Eigen::VectorXd x;
    Eigen::VectorXd residuals;
    /// (J^T J)^-1 of the unknowns at x, for residuals of unit variance
    Eigen::MatrixXd covariance;
    bool isDetermined = false; ///< false: some unknown has no effect, and covariance is empty
};

/// Minimizes the sum of squares of \a residuals(x), starting at \a start, by the
/// Levenberg-Marquardt method with a numerical Jacobian. Unknowns should be scaled so that their
/// range is of the order of 1: metres, radians, focal lengths.
LeastSquares leastSquares(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                          const Eigen::VectorXd& start);

} // namespace midair::bridge
