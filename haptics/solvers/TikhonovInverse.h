#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

namespace midair::haptics
{

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
    /// Returns G G^- = I - lambda (K + lambda I)^-1, which maps requested pressures at the points
    /// to those reached.
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
