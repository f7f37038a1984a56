#pragma once

#include "haptics/FieldProblem.h"

namespace midair::haptics
{

/// One Gauss-Newton correction of the transducers' phases towards |p_l| = s a_l.
/// With J_li = d|p_l|/d phi_i = -Im(conj(u_l) G_li q_i) and D = diag(1/|z_i|), z = G* c, the step is
///     d phi = D J^T x,  J D J^T x = s a - |p|  (conjugate gradients in the space of the points, rows scaled by 1/(s a_l)).
/// To first order it is what changing c_l by x_l u_l does to the phases of G* c, so the weights of the next update follow
/// by c_l + x_l u_l.
class PhaseCorrection
{
public:
    /// Turns field.q; field.u, y, inverse belong to it. Stops at a relative residual rms below \a tolerance or after
    /// \a maxSteps; returns the steps taken. No allocation after the first call of a size.
    int solve(FieldProblem& field, float s, double tolerance, int maxSteps, bool weighted);
    /// x_l of the last solve.
    float multiplier(int l) const { return _x[l] * _scale[l]; }

private:
    void reserve(const FieldProblem& field);
    void pass(FieldProblem& field, bool form, float alpha, const float* direction);

    AlignedBuffer<float> _J, _root, _t, _sum;
    Eigen::VectorXf _x, _r, _d, _Ad, _scale;
    SplitVector _ignored;
};

} // namespace midair::haptics
