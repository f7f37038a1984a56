#pragma once

#include "haptics/solvers/FieldProblem.h"

namespace midair::haptics
{

/// One Gauss-Newton correction of the transducers' phases towards |p_l| = s a_l (SOLVER.md, "The
/// step"). With J_li = d|p_l|/d phi_i = -Im(conj(u_l) G_li q_i) and D = diag(1/|z_i|), z = G* c, it
/// is
///     d phi = D J^T x,  J D J^T x = s a - |p|
/// where x is found by conjugate gradients in the space of the points, with rows scaled by 1/(s
/// a_l). To first order the step is what a change of c_l by x_l u_l does to the phases of G* c, so
/// the weights of the next update follow by c_l + x_l u_l. J is formed once, in fixed point: the
/// steps of CG then read a quarter of what G in float would be.
class GaussNewtonStep
{
public:
    /// \a largestTurn_rad: of a phase in one step; \a mostFreedom: cap on 1/|z_i|, over its mean.
    GaussNewtonStep(float largestTurn_rad, float mostFreedom) :
        _largestTurn_rad(largestTurn_rad),
        _mostFreedom(mostFreedom)
    {
    }
    /// Finds the step from \a q, about which p is linearised; field.u, y and inverse belong to it.
    /// \a weights are w (n, > 0): no change of the phases of q alters w.|p| to first order, so that
    /// s = (w.|p|)/(w.a), and the search keeps orthogonal to that direction. Ends at a relative
    /// residual whose rms is at most \a tolerance, or after \a maxSteps; returns the steps taken.
    /// Allocates nothing after the first call of a size.
    int solve(FieldProblem& field,
              const SplitVector& q,
              const Eigen::VectorXf& weights,
              double tolerance,
              int maxSteps);
    /// Takes \a fraction of the step in one block of \a q.
    void turn(const FieldProblem& field, int block, float fraction, SplitVector& q) const;
    /// x_l of the last solve.
    float multiplier(int l) const { return _steps > 0 ? _x[l] * _scale[l] : 0.0f; }

private:
    void reserve(const FieldProblem& field);
    void findRoots(const FieldProblem& field);
    void form(const FieldProblem& field, const SplitVector& q, int block);
    void pass(FieldProblem& field, const SplitVector& q, bool formed, const float* direction);

    float _largestTurn_rad, _mostFreedom;
    base::AlignedBuffer<std::int32_t> _jacobian; // (n + 1)/2 x m pairs of rows
    base::AlignedBuffer<float> _unit; // blocks x n: what rows of J are to be multiplied by
    base::AlignedBuffer<float> _root, _t, _sum;  // m
    base::AlignedBuffer<float> _scaledDirection; // threads x n
    Eigen::VectorXf _x, _r, _d, _curved, _scale, _flat;
    int _even = 0;   // n, or n + 1 where that is odd
    int _stride = 0; // of _unit and _scaledDirection
    int _steps = 0;
    float _alpha = 0.0f; // the step along _t that is not in _sum yet
};

} // namespace midair::haptics
