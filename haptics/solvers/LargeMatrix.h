#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// Cholesky factor L of a Hermitian positive definite matrix A = L L*. Large matrices are factored
/// and inverted in steps, with Stopped thrown between them on a stop request. Small ones take a few
/// milliseconds in one step.
class BlockCholesky
{
public:
    BlockCholesky() = default;
    explicit BlockCholesky(const Eigen::MatrixXcd& A, const base::StopToken& stop = {})
    {
        compute(A, stop);
    }

    /// Factors \a A, reading its lower triangle. Returns false if it is not positive definite, as
    /// does isPositive() afterwards.
    bool compute(Eigen::MatrixXcd A, const base::StopToken& stop = {});
    bool isPositive() const { return _positive; }
    /// Returns true if no entry of L is NaN or infinite.
    bool isFinite() const;

    Eigen::MatrixXcd inverse(const base::StopToken& stop = {}) const;
    Eigen::VectorXcd solve(const Eigen::VectorXcd& b) const;

private:
    Eigen::MatrixXcd _lower; // L, in the lower triangle
    bool _positive = false;
};

/// Complete decomposition of a Hermitian matrix: ascending eigenvalues, and eigenvectors as
/// columns.
struct HermitianAxes
{
    Eigen::VectorXd values;
    Eigen::MatrixXcd vectors;
};

/// Decomposes \a A, reading its lower half. Takes cubic time in its size, and can't be stopped.
HermitianAxes hermitianAxes(const Eigen::MatrixXcd& A);
/// Returns only the eigenvalues, which is faster.
Eigen::VectorXd hermitianValues(const Eigen::MatrixXcd& A);

/// Largest eigenvalue of a Hermitian matrix, and its eigenvector.
struct LeadingPair
{
    double value = 0.0;
    double residual = 0.0;   ///< |A v - value v|; an eigenvalue lies within this of value
    Eigen::VectorXcd vector; ///< v, of length 1
};

/// Returns the leading pair of \a A (n x n, Hermitian). Small matrices are decomposed; for large
/// ones restarted Lanczos with full orthogonalisation runs until residual is at most \a tolerance
/// times |A|, or until the limit of restarts. Throws Stopped on a stop request.
LeadingPair
leadingPair(const Eigen::MatrixXcd& A, double tolerance = 1e-10, const base::StopToken& stop = {});

/// The regularised inverse G^- = G* (K + lambda I)^-1 with K = G G* and lambda = lambdaRel
/// trace(K)/n, by one Cholesky factorisation of an n x n matrix. If K + lambda I is singular to
/// working precision (coincident points and lambda 0), lambda is raised until it is not.
class TikhonovInverse
{
public:
    /// Throws Stopped on a request of the field's token.
    TikhonovInverse(const FieldProblem& field, double lambdaRel);

    double lambda() const { return _lambda; }
    const Eigen::MatrixXcd& inverse() const { return _inverse; } ///< (K + lambda I)^-1
    /// Returns G G^- = I - lambda (K + lambda I)^-1, which maps requested to achieved pressures.
    Eigen::MatrixXcd projector() const;
    /// Returns M = lambda diag(a) (K + lambda I)^-1 diag(a); u* M u is the misfit plus lambda times
    /// the power.
    Eigen::MatrixXcd objective(const Eigen::VectorXf& a) const;
    /// Sets field.u to \a u and field.q to a positive multiple of G^- diag(a) u.
    void play(FieldProblem& field, const Eigen::VectorXcd& u) const;

private:
    double _lambda;
    Eigen::MatrixXcd _inverse;
};

} // namespace midair::haptics
