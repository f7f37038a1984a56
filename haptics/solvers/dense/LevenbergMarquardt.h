#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// Returns field.q (m, in the array's order).
Eigen::VectorXcf currentPhases(const FieldProblem& field);
/// Sets field.q (m, in the array's order).
void setPhases(FieldProblem& field, const Eigen::VectorXcf& q);
/// Returns field.q at full amplitude and on the array's phase levels, as the device plays it (m).
Eigen::VectorXcf playedPhases(FieldProblem& field);

/// Equalises the radiation pressure at points closer together than half a wavelength: a damped
/// Gauss-Newton descent (Levenberg 1944, Marquardt 1963) from the given field.q on
///     f(phi) = sum_l r_l^2,  r_l = 1 - |p_l|^2 / (s a_l)^2,  p = G q,  q_i = exp(j phi_i)
/// Such dense points leave no freedom between them, because |p|^2 contains no wave shorter than
/// half a wavelength. |p_l|^2, unlike |p_l|, is smooth at a zero of the field, so zeros on a curve
/// move off it instead of blocking the descent (SOLVER.md, "Dense points").
class LevenbergMarquardt
{
public:
    struct Limits
    {
        int corrections = 30;    ///< >= 0; maximum number of accepted steps
        int innerSteps = 24;     ///< >= 1; maximum number of CG steps per correction
        double tolerance = 1e-3; ///< >= 0; sqrt(f/n) at which the fit ends
        /// >= 0; the fit also ends once three corrections lower f by less than this share of it
        double progress = 2e-3;
    };

    /// Turns the phases of field.q (unit amplitudes) and sets field.p = G q, field.y = |p| and
    /// field.u = p/|p|. \a s: wanted pressure at a_l = 1, Pa, > 0. Returns the number of
    /// corrections; residual() is then sqrt(f/n). Doesn't allocate after the first call for a size.
    int fit(FieldProblem& field, double s, const Limits& limits);
    double residual() const { return _residual; }

    /// Makes \a rounds rounds of projectionRound() from the phases field.u. The first weights are
    /// the targets; before each round the weights are scaled to the mean 1. A cheap start for
    /// fit().
    void project(FieldProblem& field, int rounds);

private:
    void reserve(const FieldProblem& field);
    double measure(FieldProblem& field, double s);
    void step(FieldProblem& field, double damping, int innerSteps);
    void pass(FieldProblem& field, float alpha);
    void turn(FieldProblem& field);

    Eigen::VectorXf _r, _x, _rest, _direction, _product, _weight;
    base::AlignedBuffer<float> _d, _sum; // m, rad: turns of a CG direction and of the whole step
    SplitVector _w, _t, _kept;
    double _residual = 0.0;
    double _gain = 0.0; // mean of diag(J J^T)
};

} // namespace midair::haptics
