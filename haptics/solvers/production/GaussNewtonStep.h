#pragma once

#include "haptics/solvers/production/QuietPoints.h"

namespace midair::haptics
{

/// One Gauss-Newton correction of the transducers' phases towards |p_l| = s a_l (SOLVER.md, "The
/// step"). With J_li = d|p_l|/d phi_i = -Im(conj(u_l) G_li q_i) and D = diag(1/|z_i|), z = G* c, it
/// is
///     d phi = D J^T x,  J D J^T x = s a - |p|
/// where x is found by conjugate gradients (CG) in the space of the points, with rows scaled by
/// 1/(s a_l), where a_l is at least QuietPoints::kQuiet. To first order the step equals the effect
/// of changing c_l by x_l u_l on the phases of G* c, so the next update's weights are those of c_l
/// + x_l u_l. A quiet point has a second row, with j u_l in place of u_l and right-hand side 0: its
/// pressure keeps its phase. J is formed once, in fixed point, so that each CG step reads a quarter
/// of the memory of G in float.
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
    /// to \a q. \a weights: w (a number per row: Re(c_l conj(u_l)) for a point, Im(c_l conj(u_l))
    /// for the second row of a quiet one). To first order no phase change of q changes w.|p|, so s
    /// = (w.|p|)/(w.a), and the search stays orthogonal to that direction. Ends when the rms of the
    /// residual, in units of the level times the yard, is at most \a tolerance, or after \a
    /// maxSteps CG steps; returns the number of steps. Doesn't allocate after the first call for a
    /// size.
    int solve(FieldProblem& field,
              const SplitVector& q,
              const QuietPoints& quiet,
              const Eigen::VectorXf& weights,
              double tolerance,
              int maxSteps);
    /// Damped step towards |p_l|^2 = (s a_l)^2, s = \a level: with r_l = 1 - |p_l|^2/(s a_l)^2 and
    /// J its negative derivative,
    ///     d phi = D J^T x,  (J D J^T + mu I) x = r,
    /// r_l and its row times a_l/kQuiet if point l is quiet, where mu is \a damping times the mean
    /// curvature of J D J^T along r. The search may change w.|p|, because q need not be z/|z|.
    /// Otherwise as solve().
    int solveDamped(FieldProblem& field,
                    const SplitVector& q,
                    const QuietPoints& quiet,
                    float level,
                    double tolerance,
                    int maxSteps,
                    float damping);
    /// Turns the phases in one block of \a q by the step.
    void turn(const FieldProblem& field, int block, SplitVector& q) const;
    /// Returns x of the last solve() for a row.
    float multiplier(int row) const { return _steps > 0 ? _x[row] * _scale[row] : 0.0f; }
    /// Returns the direction of a row in that solve, u_l or j u_l.
    std::complex<float> direction(int row) const
    {
        return _equations.u.at(static_cast<std::size_t>(row));
    }

private:
    void reserve(const FieldProblem& field, const std::vector<int>& twice);
    float remainder(float rr) const;
    int conjugateSteps(
        FieldProblem& field, const SplitVector& q, double tolerance, int maxSteps, float damping);
    void findRoots(const FieldProblem& field, float mostFreedom);
    void form(const FieldProblem& field, const SplitVector& q, int thread, int block);
    void pass(FieldProblem& field, const SplitVector& q, bool formed, const float* direction);

    float _largestTurn_rad, _mostFreedom;
    float _largestTurn = 0.0f; // of the present step, rad
    Equations _equations;
    base::AlignedBuffer<std::int32_t> _jacobian; // (rows + 1)/2 x m pairs of rows
    base::AlignedBuffer<float> _unit;            // blocks x rows, factors on the rows of J
    base::AlignedBuffer<float> _root, _t, _sum;  // m
    base::AlignedBuffer<float> _scaledDirection; // threads x rows
    Eigen::VectorXf _x, _r, _d, _curved, _scale, _flat;
    Eigen::VectorXf _judged; // factors on _r for judging the error; empty: all 1
    int _even = 0;           // rows, rounded up to an even number
    int _stride = 0;         // row length of _unit and _scaledDirection
    int _steps = 0;
    float _alpha = 0.0f; // length of the step along _t that is not yet in _sum
};

} // namespace midair::haptics
