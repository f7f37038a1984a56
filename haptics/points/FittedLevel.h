#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

/// Functions that measure how well pressures y (n, Pa) fit targets a (n, any unit, all above 0).
/// All figures of the kit use them.
namespace midair::haptics
{

/// Smaller targets count as this share of the largest, also in figures; the rounding of phases to 8
/// bits leaves about as much at a zero (haptics/SOLVER.md, "Quiet points").
constexpr double kLeastTarget = 1e-3;

/// Raises targets that are too low and returns how many, except those that differ from the minimum
/// only by single-precision rounding.
template<typename Targets>
int raiseTargets(Eigen::PlainObjectBase<Targets>& a)
{
    using Scalar = typename Targets::Scalar;
    if (a.size() == 0) return 0;
    const auto least = static_cast<Scalar>(kLeastTarget) * a.maxCoeff();
    const auto raised = (a.array() < Scalar(1.0 - 1e-6) * least).count();
    if (raised > 0) a = a.cwiseMax(least).eval();
    return static_cast<int>(raised);
}

/// Returns s = (y.a)/(a.a), the least-squares level of a in y; Pa at a_l = 1. Computed in the
/// precision of the vectors. Not finite if all targets are 0.
template<typename Achieved, typename Targets>
typename Achieved::Scalar fittedLevel(const Eigen::MatrixBase<Achieved>& y,
                                      const Eigen::MatrixBase<Targets>& a)
{
    return y.dot(a) / a.squaredNorm();
}

/// Returns sqrt(mean((y_l/(s a_l) - 1)^2)), computed in the precision of the vectors; s > 0.
template<typename Achieved, typename Targets>
typename Achieved::Scalar relativeRms(const Eigen::MatrixBase<Achieved>& y,
                                      const Eigen::MatrixBase<Targets>& a,
                                      typename Achieved::Scalar s)
{
    using Scalar = typename Achieved::Scalar;
    return std::sqrt((y.array() / (s * a.array()) - Scalar(1)).square().mean());
}

/// Returns s = (w.y)/(w.a), the level at which the residuals s a - y, weighted by \a w, sum to 0.
template<typename Weights, typename Achieved, typename Targets>
typename Achieved::Scalar weightedLevel(const Eigen::MatrixBase<Weights>& w,
                                        const Eigen::MatrixBase<Achieved>& y,
                                        const Eigen::MatrixBase<Targets>& a)
{
    return w.dot(y) / w.dot(a);
}

/// Returns the loudness E = s |a| / mean_l(sum_i |G_li|) of a field at the level \a s, for targets
/// of norm \a norm; \a meanRowSum is the denominator, Pa. 1: the energy of one focus, shared by all
/// points.
template<typename Scalar>
Scalar loudnessOf(Scalar s, Scalar norm, Scalar meanRowSum)
{
    return s * norm / meanRowSum;
}

/// A point falls short if it is below its target in Pa by more than this fraction.
constexpr double kShortBy = 0.01;

/// Targets below this share of the largest are near nothing: their errors are relative to the
/// largest target, because relative to their own they are meaningless (haptics/SOLVER.md,
/// `kFaint`).
constexpr double kNearNothing = 0.01;

/// Returns true if target \a a is near nothing compared with \a largest.
inline bool isNearNothing(double a, double largest)
{
    constexpr double kSingle = 1.0 - 1e-6; // targets may be in single precision
    return a < kSingle * kNearNothing * largest;
}

/// Errors of points: g_l = (y_l/s - a_l)/max(a), relative to the largest target, and e_l = y_l/(s
/// a_l) - 1, but g_l if isNearNothing(a_l).
struct RelativeErrors
{
    double rms = 0.0;          ///< sqrt(mean(e_l^2))
    double max = 0.0;          ///< the largest |e_l|
    double rmsOfLargest = 0.0; ///< sqrt(mean(g_l^2))
    double maxOfLargest = 0.0; ///< the largest |g_l|

    /// Sets the figures of the same names in \a figures.
    template<typename Figures>
    void tell(Figures& figures) const
    {
        figures.rms = rms;
        figures.max = max;
        figures.rmsOfLargest = rmsOfLargest;
        figures.maxOfLargest = maxOfLargest;
    }
};

/// Returns the errors at the level \a s > 0, summed in double in the points' order, so that equal
/// pressures give equal bits with any instruction set of Eigen. \a least: lower bound of the
/// largest target.
template<typename Achieved, typename Targets>
RelativeErrors relativeErrors(const Eigen::MatrixBase<Achieved>& y,
                              const Eigen::MatrixBase<Targets>& a,
                              double s,
                              double least = 0.0)
{
    RelativeErrors errors;
    double squares = 0.0, squaresOfLargest = 0.0;
    const double largest = std::max(static_cast<double>(a.maxCoeff()), least);
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        const double own = y[l] / (s * a[l]) - 1.0, ofLargest = own * (a[l] / largest);
        const double error = isNearNothing(a[l], largest) ? ofLargest : own;
        squares += error * error;
        squaresOfLargest += ofLargest * ofLargest;
        errors.max = std::max(errors.max, std::fabs(error));
        errors.maxOfLargest = std::max(errors.maxOfLargest, std::fabs(ofLargest));
    }
    errors.rms = std::sqrt(squares / static_cast<double>(a.size()));
    errors.rmsOfLargest = std::sqrt(squaresOfLargest / static_cast<double>(a.size()));
    return errors;
}

/// Shortfall of pressures y from targets a, both in Pa.
struct Shortfall
{
    int points = 0;         ///< points below their target by more than kShortBy
    double worst = 0.0;     ///< largest 1 - y_l/a_l; 0: no point is below its target
    Eigen::Index which = 0; ///< index of that point
};

/// Returns the shortfall from the targets s a.
template<typename Achieved, typename Targets>
Shortfall
shortfallOf(const Eigen::MatrixBase<Achieved>& y, const Eigen::MatrixBase<Targets>& a, double s)
{
    Shortfall shortfall;
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        const double missing = 1.0 - y[l] / (s * a[l]);
        if (missing > kShortBy) ++shortfall.points;
        if (missing <= shortfall.worst) continue;
        shortfall.worst = missing;
        shortfall.which = l;
    }
    return shortfall;
}

/// Like fittedLevel(), but summed in double and in the points' order.
template<typename Achieved, typename Targets>
double fittedLevelInOrder(const Eigen::MatrixBase<Achieved>& y, const Eigen::MatrixBase<Targets>& a)
{
    double ya = 0.0, aa = 0.0;
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        ya += static_cast<double>(y[l]) * a[l];
        aa += static_cast<double>(a[l]) * a[l];
    }
    return ya / aa;
}

} // namespace midair::haptics
