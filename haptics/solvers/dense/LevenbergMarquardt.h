#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// field.q without its padding, as it stands (m).
Eigen::VectorXcf currentPhases(const FieldProblem& field);
void setPhases(FieldProblem& field, const Eigen::VectorXcf& q);
/// field.q at full amplitude and on the array's phase levels, as the device plays it (m).
Eigen::VectorXcf playedPhases(FieldProblem& field);

/// Makes the radiation pressure equal at points that stand closer than half a wavelength: a damped
/// Gauss-Newton descent (Levenberg 1944, Marquardt 1963) from whatever field.q is, on
///     f(phi) = sum_l r_l^2,  r_l = 1 + g_l - |p_l|^2 / (s a_l)^2,  p = G q,  q_i = exp(j phi_i)
/// Between points that dense the field has no freedom left, since |p|^2 holds no wave shorter than
/// half a wavelength. The squares, unlike |p_l| itself, are smooth where the field has a zero, so
/// that zeros on a curve are pushed off it instead of blocking the descent (SOLVER.md, "Dense
/// points").
class LevenbergMarquardt
{
public:
    struct Limits
    {
        int corrections = 30;    ///< >= 0; accepted steps at most
        int innerSteps = 24;     ///< >= 1; steps of conjugate gradients for one correction
        double tolerance = 1e-3; ///< >= 0; the fit ends at sqrt(f/n) of this
        /// >= 0; the fit also ends once three corrections lower f by less than this share of it.
        double progress = 2e-3;
    };

    /// Turns field.q (unit amplitudes) and leaves field.p = G q, field.y = |p| and field.u, its
    /// phases. \a s is the pressure wanted at a_l = 1, Pa, > 0. Returns the corrections made;
    /// residual() is then sqrt(f/n). Allocates nothing after the first call of a size.
    int fit(FieldProblem& field, double s, const Limits& limits);
    /// The same with \a given for g (n numbers): what the other fields of a cycle leave to this
    /// one. Empty: zeros.
    int fit(FieldProblem& field, double s, const Eigen::VectorXf& given, const Limits& limits);
    double residual() const { return _residual; }

    /// Rounds of WeightedRound.h from the phases field.u, with the targets for first weights, which
    /// are brought to a mean of 1 before each round. Cheap; fit() then starts from where they end.
    void project(FieldProblem& field, int rounds);

private:
    void reserve(const FieldProblem& field);
    double measure(FieldProblem& field, double s, const Eigen::VectorXf& given);
    void step(FieldProblem& field, double damping, int innerSteps);
    void pass(FieldProblem& field, float alpha);
    void turn(FieldProblem& field);

    Eigen::VectorXf _r, _x, _rest, _direction, _product, _weight;
    base::AlignedBuffer<float> _d, _sum; // of the direction, and of the whole step, rad
    SplitVector _w, _t, _kept;
    double _residual = 0.0;
    double _gain = 0.0; // mean of diag(J J^T)
};

} // namespace midair::haptics
