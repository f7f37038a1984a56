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

/// Evens out the radiation pressure at points that stand closer than half a wavelength: a damped Gauss-Newton descent on
///     f(phi) = sum_l r_l^2,  r_l = 1 + g_l - |p_l|^2 / (s a_l)^2,  p = G q,  q_i = exp(j phi_i)
/// (Levenberg 1944, Marquardt 1963) from whatever field.q is. Between points that dense nothing is left to chance, |p|^2 being
/// limited to waves of half a wavelength. The squares, unlike |p_l| itself, are smooth where the field has a zero, so
/// that zeros on a curve are pushed off it instead of holding the descent up.
class LevenbergMarquardt
{
public:
    struct Limits
    {
        int corrections = 30;    ///< >= 0; accepted steps at most
        int innerSteps = 24;     ///< >= 1; of conjugate gradients for one correction
        double tolerance = 1e-3; ///< >= 0; done at sqrt(f/n) of this
        double progress = 2e-3; ///< >= 0; or once three corrections lower f by less than this share
    };

    /// Turns field.q (unit amplitudes) and leaves field.p = G q, field.y = |p|, field.u its phases. \a s > 0, Pa. Returns the
    /// corrections made; residual() is sqrt(f/n) after them. No allocation after the first call of a size.
    int fit(FieldProblem& field, double s, const Limits& limits);
    /// The same with g, of n numbers: what other fields of a cycle leave to this one. Empty: 0.
    int fit(FieldProblem& field, double s, const Eigen::VectorXf& given, const Limits& limits);
    double residual() const { return _residual; }

    /// Weighted projections from the phases field.u: q = phase(G* (w a u)), p = G q, u = phase(p), and
    /// w_l times the mean over |p_l|/a_l, by a factor of 5 at most, a round. Cheap; where fit sets in.
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
