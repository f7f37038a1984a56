#pragma once

#include "haptics/solvers/FieldProblem.h"

namespace midair::haptics
{

/// One Gauss-Newton correction of the transducers' phases towards |p_l| = s a_l (SOLVER.md, "The
/// step"). With J_li = d|p_l|/d phi_i = -Im(conj(u_l) G_li q_i) and D = diag(1/|z_i|), z = G* c, it
/// is
///     d phi = D J^T x,  J D J^T x = s a - |p|
/// where x is found by conjugate gradients (CG) in the space of the points, with rows scaled by
/// 1/(s a_l). To first order the step equals the effect of changing c_l by x_l u_l on the phases of
/// G* c, so the next update's weights are those of c_l + x_l u_l. J is formed once, in fixed point,
/// so that each CG step reads a quarter of the memory that G takes in float.
class GaussNewtonStep
{
public:
    /// \a largestTurn_rad: largest change of a phase in one step. \a mostFreedom: cap on 1/|z_i|,
    /// relative to its mean.
    GaussNewtonStep(float largestTurn_rad, float mostFreedom) :
        _largestTurn_rad(largestTurn_rad),
        _mostFreedom(mostFreedom)
    {
    }
    /// Finds the step from \a q, where p is linearised; field.u, field.y and field.inverse belong
    /// to \a q. \a weights: w (n, > 0). To first order no change of the phases of q changes w.|p|,
    /// so s = (w.|p|)/(w.a), and the search stays orthogonal to that direction. Ends when the rms
    /// of the relative residual is at most \a tolerance, or after \a maxSteps CG steps; returns the
    /// number of steps taken. Allocates nothing after the first call for a size.
    int solve(FieldProblem& field,
              const SplitVector& q,
              const Eigen::VectorXf& weights,
              double tolerance,
              int maxSteps);
    /// The damped step towards |p_l|^2 = (s a_l)^2, s = \a level: with r_l = 1 - |p_l|^2/(s a_l)^2
    /// and J its negative derivative,
    ///     d phi = D J^T x,  (J D J^T + mu I) x = r,
    /// where mu is \a damping times the mean curvature of J D J^T along r. The search is free to
    /// change w.|p|, as q need not be z/|z|. The rest is as in solve().
    int solveDamped(FieldProblem& field,
                    const SplitVector& q,
                    float level,
                    double tolerance,
                    int maxSteps,
                    float damping);
    /// Turns the phases in one block of \a q by the step.
    void turn(const FieldProblem& field, int block, SplitVector& q) const;
    /// Returns x_l of the last solve().
    float multiplier(int l) const { return _steps > 0 ? _x[l] * _scale[l] : 0.0f; }

private:
    void reserve(const FieldProblem& field);
    int conjugateSteps(
        FieldProblem& field, const SplitVector& q, double tolerance, int maxSteps, float damping);
    void findRoots(const FieldProblem& field, float mostFreedom);
    void form(const FieldProblem& field, const SplitVector& q, int block);
    void pass(FieldProblem& field, const SplitVector& q, bool formed, const float* direction);

    float _largestTurn_rad, _mostFreedom;
    float _largestTurn = 0.0f;                   // of the present step, rad
    base::AlignedBuffer<std::int32_t> _jacobian; // (n + 1)/2 x m pairs of rows
    base::AlignedBuffer<float> _unit;            // blocks x n, factors on the rows of J
    base::AlignedBuffer<float> _root, _t, _sum;  // m
    base::AlignedBuffer<float> _scaledDirection; // threads x n
    Eigen::VectorXf _x, _r, _d, _curved, _scale, _flat;
    int _even = 0;   // n rounded up to an even number
    int _stride = 0; // row length of _unit and _scaledDirection
    int _steps = 0;
    float _alpha = 0.0f; // length of the step along _t that is not yet in _sum
};

} // namespace midair::haptics
