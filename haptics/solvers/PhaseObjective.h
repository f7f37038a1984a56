#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/propagation/kernels/PhaseKernels.h"
#include "haptics/solvers/LargeMatrix.h"

#include <Eigen/Core>

namespace midair::haptics
{

class PropagationMatrix;

/// Returns K = G G* (n x n) of a float matrix: products in float over a block of transducers, sums
/// over the blocks in double. Checks for a stop request between blocks and then throws Stopped.
Eigen::MatrixXcd gramMatrix(const PropagationMatrix& G, const base::StopToken& stop = {});
/// Returns K = G G*, all in double.
Eigen::MatrixXcd gramMatrix(const Eigen::MatrixXcd& G);

/// The phase-retrieval problem for a set of control points: minimise the Hermitian form u* M u over
/// |u_l| = 1, with
///     K = G G*,  lambda = lambdaRel trace(K) / n,  M = lambda diag(a) (K + lambda I)^-1 diag(a).
/// Its value is the least misfit plus power for pressures with the phases u (the paper's equation 7
/// in closed form):
///     u* M u = min over q of |G q - diag(a) u|^2 + lambda |q|^2,
/// reached by q = G* (K + lambda I)^-1 diag(a) u.
/// Needs one Cholesky factorisation and no singular values. Its unit is that of the targets,
/// squared.
class PhaseObjective
{
public:
    static constexpr double kSmallestLambdaRel = 1e-5;

    PhaseObjective() = default;

    /// \a K: n x n, Hermitian, positive semidefinite. \a targets: n, finite, >= 0, not all 0. \a
    /// lambdaRel: kSmallestLambdaRel .. 1e9; below it the rounding of K would matter. Throws
    /// InputError for other input, and Stopped on a stop request.
    PhaseObjective(Eigen::MatrixXcd K,
                   const Eigen::VectorXd& targets,
                   double lambdaRel = 0.1,
                   const base::StopToken& stop = {});

    int size() const { return static_cast<int>(_matrix.cols()); }
    double lambda() const { return _lambda; } ///< Pa^2
    const Eigen::VectorXd& targets() const { return _a; }
    const Eigen::MatrixXcd& M() const { return _matrix; }
    double trace() const { return _trace; } ///< trace(M), the mean of u* M u over random phases
    kernels::HermitianView<double> view() const; ///< M
    /// M n / trace(M), whose diagonal has the mean 1
    kernels::HermitianView<float> fastView() const;

    /// Upper bound of |I - X (K + lambda I)| in Frobenius norm, where X is the computed inverse in
    /// M: the error of that inverse.
    double inverseError() const { return _inverseError; }

    /// Returns u* M u; \a u: n, of modulus 1.
    double value(const Eigen::VectorXcd& u) const;
    /// Returns d(u* M u) / d phi_l = 2 Im(conj(u_l) (M u)_l) for u_l = exp(j phi_l).
    Eigen::VectorXd gradient(const Eigen::VectorXcd& u) const;
    /// Coordinate descent: each phase in turn moves to its minimum, the phase of minus its row's
    /// sum over the others, and beyond (over-relaxation). Ends once a round lowers u* M u by at
    /// most \a tolerance * trace(), or after \a maxRounds; returns u* M u. Throws Stopped between
    /// rounds on a request of \a stop.
    double descend(Eigen::VectorXcd& u,
                   int maxRounds = 1000,
                   double tolerance = 1e-9,
                   const base::StopToken& stop = {}) const;
    /// The same in float, several times faster; \a tolerance: at least 1e-6, or 0 to continue while
    /// rounds lower the value.
    double descendFast(Eigen::VectorXcd& u,
                       int maxRounds,
                       double tolerance,
                       const base::StopToken& stop = {}) const;

    /// Returns w = (K + lambda I)^-1 diag(a) u, so that q = G* w.
    Eigen::VectorXcd weights(const Eigen::VectorXcd& u) const;
    /// Returns the minimum over s > 0 and phases u of |s p - diag(a) u|^2 + lambda |s q|^2 for a
    /// given field with pressures \a p = G q (n) and \a power |q|^2, which is
    /// sum a^2 - (sum a |p|)^2 / (|p|^2 + lambda |q|^2). It is never below the least u* M u.
    double misfitAndPower(const Eigen::VectorXcd& p, double power) const;

private:
    BlockCholesky _factor; // factor of K + lambda I
    Eigen::VectorXd _a;
    Eigen::MatrixXcd _matrix;
    Eigen::MatrixXd _re, _im; // parts of M, padded for the kernels
    Eigen::MatrixXf _fastRe, _fastIm;
    double _lambda = 0.0, _trace = 0.0, _inverseError = 0.0;
};

} // namespace midair::haptics
