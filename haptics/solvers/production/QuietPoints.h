#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace midair::haptics
{

/// Points whose targets are far below the largest (SOLVER.md, "Quiet points"). There the other
/// points' field is as loud as the target or louder, so |p_l| = s a_l is not linear in a step of
/// its size, and the multiplier c_l can have any phase, not only that of p_l. Each quiet point
/// counts as two linear equations, p_l = s a_l u_l. Without quiet points this class has no effect.
class QuietPoints
{
public:
    static constexpr float kQuiet = 0.3f;  ///< targets below this share of the largest are quiet
    static constexpr float kRows = 0.5f;   ///< maximum number of equations, over the number of
                                           ///< transducers
    static constexpr float kFaint = 0.01f; ///< below it, the error relative to the largest target
                                           ///< gains weight

    /// Finds the quiet points among \a targets, whose largest is 1, for an array of \a m
    /// transducers.
    void choose(const Eigen::VectorXf& targets, int m)
    {
        _points.clear();
        if (_yard.size() != targets.size()) _yard.resize(targets.size());
        for (Eigen::Index l = 0; l < targets.size(); ++l)
        {
            if (isQuiet(targets[l])) _points.push_back(static_cast<int>(l));
            _yard[l] = yardOf(targets[l]);
        }
        // The quietest ones first, as many as m phases support.
        const auto most = static_cast<std::size_t>(
            std::max(0.0f, kRows * static_cast<float>(m) - static_cast<float>(targets.size())));
        _twice = _points;
        if (_twice.size() <= most) return;
        std::stable_sort(
            _twice.begin(), _twice.end(), [&](int a, int b) { return targets[a] < targets[b]; });
        _twice.resize(most);
        std::sort(_twice.begin(), _twice.end());
    }
    static bool isQuiet(float target) { return target < kQuiet; }
    /// Weight of a quiet point's squared error in a damped step: that of the same error in Pa at a
    /// point of kQuiet.
    static float shareOf(float target) { return std::min(target / kQuiet, 1.0f); }

    bool any() const { return !_points.empty(); }
    int count() const { return static_cast<int>(_points.size()); }
    const std::vector<int>& points() const { return _points; } ///< ascending indices
    const std::vector<int>& twice() const { return _twice; }   ///< those with two equations
    /// Unit of errors, over the level (n): the target; for a quiet one a length between it and
    /// kQuiet, and kQuiet itself for targets that 8 bits can't resolve.
    const Eigen::VectorXf& yard() const { return _yard; }
    /// Returns the rms of (y_l - s a_l)/(s d_l), d the yard: errorOf() without quiet points.
    float error(const FieldProblem& field, float s) const
    {
        if (!any()) return errorOf(field, s);
        return std::sqrt(
            ((field.y.array() - s * field.a.array()) / (s * _yard.array())).square().mean());
    }
    /// Returns the rms of (y_l - s a_l)/(s max(a_l, kQuiet)): the nonlinearity of a step.
    float bend(const FieldProblem& field, float s) const
    {
        if (!any()) return errorOf(field, s);
        return std::sqrt(
            ((field.y.array() - s * field.a.array()) / (s * field.a.array().max(kQuiet)))
                .square()
                .mean());
    }
    /// Returns the contribution of rounding to error(): roundingError() without quiet points. It is
    /// the same disturbance in Pa at all points, in units of their yards.
    float rounding(const FieldProblem& field, float amplitude) const
    {
        if (!any()) return roundingError(field, amplitude);
        return disturbance(field, amplitude) * std::sqrt(_yard.array().square().inverse().mean());
    }
    /// Returns rounding's disturbance of a point, in Pa over the level of the largest target.
    static float disturbance(const FieldProblem& field, float amplitude)
    {
        return roundingError(field, amplitude) *
               std::sqrt(field.a.squaredNorm() / static_cast<float>(field.n()));
    }

private:
    static float yardOf(float target)
    {
        if (!isQuiet(target)) return target;
        const float least = kQuiet * std::cbrt(kFaint / kQuiet);
        return target < kFaint ? std::min(least * std::sqrt(kFaint / target), kQuiet)
                               : kQuiet * std::cbrt(target / kQuiet);
    }

    std::vector<int> _points, _twice;
    Eigen::VectorXf _yard; // n
};

/// Equations of a step or of shaped rounding: a row for each point, then a second one for each of
/// \a twice, orthogonal to the first.
class Equations
{
public:
    void choose(const FieldProblem& field, const std::vector<int>& twice)
    {
        const int n = field.n();
        _n = n;
        _twice = &twice;
        u.reserve(static_cast<std::size_t>(rows()));
        copy(field.u, u, static_cast<std::size_t>(n));
        for (int row = n; row < rows(); ++row)
        {
            const auto l = static_cast<std::size_t>(point(row));
            u.set(static_cast<std::size_t>(row), std::complex<float>(0.0f, 1.0f) * field.u.at(l));
        }
        if (rows() == n) return;
        _stride = static_cast<std::size_t>(rows()) * PropagationMatrix::kBlockWidth;
        _rows.reserveUnset(_stride * static_cast<std::size_t>(field.threads()));
    }
    int rows() const { return _n + static_cast<int>(_twice->size()); }
    int point(int row) const
    {
        return row < _n ? row : (*_twice)[static_cast<std::size_t>(row - _n)];
    }
    /// Rows of G in one block from lane \a first on, \a width lanes each (FIXED). Without points in
    /// twice they are the matrix's own, with the block's \a width.
    const std::int32_t*
    gather(const FieldProblem& field, int thread, int block, int first, int count, int& width)
    {
        const std::int32_t* G = field.G.fixedData(block) + first;
        width = field.G.width(block);
        if (rows() == _n) return G;
        std::int32_t* to = _rows.data() + static_cast<std::size_t>(thread) * _stride;
        for (int row = 0; row < rows(); ++row)
            std::copy_n(G + static_cast<std::ptrdiff_t>(point(row)) * width,
                        count,
                        to + static_cast<std::ptrdiff_t>(row) * count);
        width = count;
        return to;
    }

    SplitVector u; ///< rows(), directions in which the pressures should change

private:
    int _n = 0;
    const std::vector<int>* _twice = nullptr;
    std::size_t _stride = 0;
    base::AlignedBuffer<std::int32_t> _rows; // threads x rows x lanes
};

} // namespace midair::haptics
