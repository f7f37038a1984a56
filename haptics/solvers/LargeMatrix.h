#pragma once

#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// Cholesky factor L L* = A of a Hermitian positive definite matrix. For large ones it is made, and
/// used, in steps between which Stopped is thrown where that is asked for; small ones take a few
/// milliseconds at once.
class BlockCholesky
{
public:
    BlockCholesky() = default;
    explicit BlockCholesky(const Eigen::MatrixXcd& A, const base::StopToken& stop = {})
    {
        compute(A, stop);
    }

    /// Reads the lower triangle of \a A. False, as isPositive() from then on, where it is not
    /// positive definite.
    bool compute(Eigen::MatrixXcd A, const base::StopToken& stop = {});
    bool isPositive() const { return _positive; }
    /// Nothing in it is NaN or infinite.
    bool isFinite() const;

    Eigen::MatrixXcd inverse(const base::StopToken& stop = {}) const;
    Eigen::VectorXcd solve(const Eigen::VectorXcd& b) const;

private:
    Eigen::MatrixXcd _lower; // L, in the lower triangle
    bool _positive = false;
};

/// The largest eigenvalue of a Hermitian matrix, and its vector.
struct LeadingPair
{
    double value = 0.0;
    double residual = 0.0; ///< |A v - value v|: an eigenvalue lies within this of value
    Eigen::VectorXcd vector;
};

/// Of \a A (n x n, Hermitian): the whole decomposition where n is small; else restarted Lanczos
/// with full orthogonalisation until residual is at most \a tolerance times |A|, or as near as it
/// comes. Throws Stopped where that is asked for.
LeadingPair
leadingPair(const Eigen::MatrixXcd& A, double tolerance = 1e-10, const base::StopToken& stop = {});

} // namespace midair::haptics
