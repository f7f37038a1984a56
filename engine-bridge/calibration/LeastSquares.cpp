#include "engine-bridge/calibration/LeastSquares.h"

#include <Eigen/Cholesky>

#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr double kDifference = 1e-7; ///< step of an unknown, for the Jacobian
constexpr int kMostRounds = 60;
constexpr double kLeastGain = 1e-12;  ///< of the sum of squares: smaller ones end the iteration
constexpr double kLeastPivot = 1e-10; ///< relative; smaller ones mean an undetermined unknown

Eigen::MatrixXd jacobianOf(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                           const Eigen::VectorXd& x)
{
    Eigen::MatrixXd jacobian;
    for (Eigen::Index i = 0; i < x.size(); ++i)
    {
        Eigen::VectorXd low = x, high = x;
        low[i] -= kDifference;
        high[i] += kDifference;
        const Eigen::VectorXd slope = (residuals(high) - residuals(low)) / (2.0 * kDifference);
        if (i == 0) jacobian.resize(slope.size(), x.size());
        jacobian.col(i) = slope;
    }
    return jacobian;
}

} // namespace

Eigen::Isometry3d motionOf(const Eigen::Matrix<double, 6, 1>& six)
{
    const Eigen::Vector3d turn = six.head<3>();
    const double angle = turn.norm();
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    if (angle > 0.0) motion.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    motion.translation() = six.tail<3>();
    return motion;
}

LeastSquares leastSquares(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                          const Eigen::VectorXd& start)
{
    LeastSquares result;
    result.x = start;
    result.residuals = residuals(start);
    double damping = 1e-3;
    Eigen::MatrixXd normal;
    for (int round = 0; round < kMostRounds; ++round)
    {
        const Eigen::MatrixXd jacobian = jacobianOf(residuals, result.x);
        normal = jacobian.transpose() * jacobian;
        const Eigen::VectorXd slope = jacobian.transpose() * result.residuals;
        const double before = result.residuals.squaredNorm();
        double gain = 0.0;
        for (int attempt = 0; attempt < 12 && !(gain > 0.0); ++attempt)
        {
            Eigen::MatrixXd damped = normal;
            damped.diagonal() *= 1.0 + damping;
            damped.diagonal().array() += 1e-15 * normal.diagonal().maxCoeff();
            const Eigen::VectorXd x = result.x - Eigen::VectorXd(damped.ldlt().solve(slope));
            const Eigen::VectorXd there = residuals(x);
            gain = before - there.squaredNorm(); // NaN is not above 0
            damping = gain > 0.0 ? 0.2 * damping : 8.0 * damping;
            if (!(gain > 0.0)) continue;
            result.x = x;
            result.residuals = there;
        }
        if (!(gain > kLeastGain * before)) break;
    }
    // Scales the unknowns, so that undetermined ones can be detected.
    const Eigen::VectorXd scale = normal.diagonal().cwiseMax(0.0).cwiseSqrt();
    if (!(scale.minCoeff() > 0.0)) return result;
    const Eigen::MatrixXd even =
        scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
    const Eigen::LDLT<Eigen::MatrixXd> parts(even);
    result.isDetermined = parts.vectorD().minCoeff() > kLeastPivot;
    if (!result.isDetermined) return result;
    const Eigen::MatrixXd inverse =
        parts.solve(Eigen::MatrixXd::Identity(even.rows(), even.cols()));
    result.covariance =
        scale.cwiseInverse().asDiagonal() * inverse * scale.cwiseInverse().asDiagonal();
    return result;
}

} // namespace midair::bridge
