#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/propagation/kernels/PhaseKernels.h"
#include "haptics/solvers/LargeMatrix.h"

#include <Eigen/Core>

namespace midair::haptics
{

class PropagationMatrix;

/// K = G G* (n x n) of a float matrix: products in float over a block of transducers, sums between
/// blocks in double. Throws Stopped, between blocks, where that is asked for.
Eigen::MatrixXcd gramMatrix(const PropagationMatrix& G, const base::StopToken& stop = {});
/// K = G G* in double throughout.
Eigen::MatrixXcd gramMatrix(const Eigen::MatrixXcd& G);

/// The phase-retrieval problem that a set of control points poses: the Hermitian form u* M u over
/// |u_l| = 1, with
///     K = G G*,  lambda = lambdaRel trace(K) / n,  M = lambda diag(a) (K + lambda I)^-1 diag(a).
/// It is the least that misfit and power can be for pressures of phases u (the paper's equation 7
/// in closed form):
///     u* M u = min over q of |G q - diag(a) u|^2 + lambda |q|^2,
/// reached by q = G* (K + lambda I)^-1 diag(a) u.
/// One Cholesky factorisation, no singular values. Unit: that of the targets, squared.
class PhaseObjective
{
public:
    static constexpr double kSmallestLambdaRel = 1e-5;

    PhaseObjective() = default;

    /// \a K n x n Hermitian positive semidefinite, \a targets n (finite, >= 0, not all 0), \a
    /// lambdaRel from kSmallestLambdaRel to 1e9: below, the rounding of K would show. Throws
    /// InputError, and Stopped where that is asked for.
    PhaseObjective(Eigen::MatrixXcd K,
                   const Eigen::VectorXd& targets,
                   double lambdaRel = 0.1,
                   const base::StopToken& stop = {});

    int size() const { return static_cast<int>(_matrix.cols()); }
    double lambda() const { return _lambda; } ///< Pa^2
    const Eigen::VectorXd& targets() const { return _a; }
    const Eigen::MatrixXcd& M() const { return _matrix; }
    double trace() const { return _trace; }      ///< of M: the mean of u* M u over random phases
    kernels::HermitianView<double> view() const; ///< M
    kernels::HermitianView<float>
    fastView() const; ///< M n / trace(M), so that its numbers are about 1

    /// u* M u; \a u (n) of modulus 1.
    double value(const Eigen::VectorXcd& u) const;
    /// d(u* M u) / d phi_l = 2 Im(conj(u_l) (M u)_l) for u_l = exp(j phi_l).
    Eigen::VectorXd gradient(const Eigen::VectorXcd& u) const;
    /// Coordinate descent: each phase in turn becomes that of minus its row's sum over the others,
    /// which is its minimum. Stops once a round gains less than \a tolerance * trace() or after \a
    /// maxRounds; returns u* M u. Throws Stopped between rounds where \a stop asks for it.
    double descend(Eigen::VectorXcd& u,
                   int maxRounds = 1000,
                   double tolerance = 1e-9,
                   const base::StopToken& stop = {}) const;
    /// The same in float, several times faster; \a tolerance 1e-6 and more.
    double descendFast(Eigen::VectorXcd& u,
                       int maxRounds,
                       double tolerance,
                       const base::StopToken& stop = {}) const;

    /// w = (K + lambda I)^-1 diag(a) u, so that q = G* w.
    Eigen::VectorXcd weights(const Eigen::VectorXcd& u) const;
    /// min over s > 0 and phases u of |s p - diag(a) u|^2 + lambda |s q|^2 for a field that is
    /// there, of pressures \a p = G q (n) and power |q|^2: sum a^2 - (sum a |p|)^2 / (|p|^2 +
    /// lambda |q|^2). Never below the least u* M u.
    double misfitAndPower(const Eigen::VectorXcd& p, double power) const;

private:
    BlockCholesky _factor; // of K + lambda I
    Eigen::VectorXd _a;
    Eigen::MatrixXcd _matrix;
    Eigen::MatrixXd _re, _im; // of M, for the kernels
    Eigen::MatrixXf _fastRe, _fastIm;
    double _lambda = 0.0, _trace = 0.0;
};

} // namespace midair::haptics
