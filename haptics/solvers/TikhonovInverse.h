#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// G^- = G* (K + lambda I)^-1 with K = G G* and lambda = lambdaRel trace(K)/n, by one Cholesky of
/// an n x n matrix. Where K + lambda I is singular to working precision (coincident points and
/// lambda 0), lambda is raised until it is not.
class TikhonovInverse
{
public:
    /// Throws Stopped where field's token asks for it.
    TikhonovInverse(const FieldProblem& field, double lambdaRel);

    double lambda() const { return _lambda; }
    const Eigen::MatrixXcd& inverse() const { return _inverse; } ///< (K + lambda I)^-1
    /// G G^- = I - lambda (K + lambda I)^-1: what the field at the points becomes of what was asked
    /// for.
    Eigen::MatrixXcd projector() const;
    /// M = lambda diag(a) (K + lambda I)^-1 diag(a): u* M u is the misfit plus lambda times the
    /// power.
    Eigen::MatrixXcd objective(const Eigen::VectorXf& a) const;
    /// field.q = G^- diag(a) u, G* being field's.
    void play(FieldProblem& field, const Eigen::VectorXcd& u) const;

private:
    double _lambda;
    Eigen::MatrixXcd _inverse;
};

} // namespace midair::haptics
