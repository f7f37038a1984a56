#include "engine-bridge/calibration/Calibration.h"

#include "engine-bridge/calibration/PlaceError.h"
#include "haptics/base/InputError.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/text/Range.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Options of robustFit().
struct RobustFitOptions
{
    bool scaling = false;       ///< also fit a uniform scale
    double outlierSigmas = 4.0; ///< > 0; pairs with larger residuals, in sigmas, are outliers
    int trials = 1000;          ///< >= 1; the most triples to try
    std::uint64_t seed = 1;
};

/// The map array = linear world + offset that fits the mutually consistent pairs.
struct RobustFit
{
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity(); ///< rotation times scale
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();     ///< metres
    double scale = 1.0;
    Eigen::VectorXd residuals_m; ///< n
    std::vector<int> inliers;    ///< numbers of those pairs, ascending
    double noise_m = 0.0;        ///< standard deviation per coordinate over the inliers
};

constexpr int kFewestForRejection = 6;  ///< with fewer pairs the wrong one can't be identified
constexpr double kFinestNoise_m = 1e-7; ///< so that rounding causes no outliers among exact pairs

using Triple = std::array<int, 3>;

PointPairs chosen(const PointPairs& pairs, const std::vector<int>& which)
{
    return {pairs.world(Eigen::all, which), pairs.array(Eigen::all, which)};
}

void fit(RobustFit& result, const PointPairs& pairs, const std::vector<int>& which, bool scaling)
{
    const PointPairs some = chosen(pairs, which);
    const Eigen::Matrix4d motion = base::nearestMotion(some.world, some.array, scaling);
    result.linear = motion.topLeftCorner<3, 3>();
    result.offset = motion.topRightCorner<3, 1>();
    result.scale = scaling ? std::cbrt(result.linear.determinant()) : 1.0;
    result.residuals_m =
        ((result.linear * pairs.world).colwise() + result.offset - pairs.array).colwise().norm();
}

std::vector<Triple> triples(int n, const RobustFitOptions& options)
{
    std::vector<Triple> result;
    const double all = n * (n - 1.0) * (n - 2.0) / 6.0;
    if (all <= options.trials)
    {
        for (int a = 0; a < n; ++a)
            for (int b = a + 1; b < n; ++b)
                for (int c = b + 1; c < n; ++c)
                    result.push_back({a, b, c});
        return result;
    }
    std::mt19937_64 random(options.seed);
    const auto pick = [&] { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    while (static_cast<int>(result.size()) < options.trials)
    {
        const Triple triple = {pick(), pick(), pick()};
        if (triple[0] != triple[1] && triple[1] != triple[2] && triple[0] != triple[2])
            result.push_back(triple);
    }
    return result;
}

/// The h-th smallest residual, h = floor(n/2) + floor((p + 1)/2) with p = 3 pairs per trial fit,
/// which has the highest breakdown point (Rousseeuw 1984).
double medianResidual(const Eigen::VectorXd& residuals)
{
    std::vector<double> sorted(residuals.data(), residuals.data() + residuals.size());
    const std::size_t h = std::min(sorted.size(), sorted.size() / 2 + 2);
    std::nth_element(
        sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(h - 1), sorted.end());
    return sorted[h - 1];
}

std::vector<int> within(const Eigen::VectorXd& residuals, double limit)
{
    std::vector<int> chosen;
    for (int k = 0; k < residuals.size(); ++k)
        if (residuals[k] <= limit) chosen.push_back(k);
    return chosen;
}

/// sqrt(sum r^2 / (3 n - parameters of the fit)).
double noise(const RobustFit& result, bool scaling)
{
    const double sum = result.residuals_m(result.inliers).squaredNorm();
    const int freedom = 3 * static_cast<int>(result.inliers.size()) - (scaling ? 7 : 6);
    return std::max(kFinestNoise_m, std::sqrt(sum / std::max(1, freedom)));
}

/// Returns the pairs that are consistent with the fit to the best triple.
std::vector<int> consensus(const PointPairs& pairs, const RobustFitOptions& options)
{
    const int n = pairs.size();
    RobustFit best;
    double bestMedian = INFINITY;
    for (const Triple& triple : triples(n, options))
    {
        RobustFit trial;
        fit(trial, pairs, {triple[0], triple[1], triple[2]}, options.scaling);
        const double median = medianResidual(trial.residuals_m);
        if (!(median < bestMedian)) continue;
        bestMedian = median;
        best = trial;
    }
    // The median length of a Gaussian 3-vector is 1.538 sigma; the other factor is Rousseeuw's for
    // small samples.
    const double sigma =
        std::max(kFinestNoise_m, bestMedian / 1.538 * (1.0 + 5.0 / std::max(1, n - 3)));
    return within(best.residuals_m, options.outlierSigmas * sigma);
}

/// Fits by least median of squares over triples (all, or random ones by seed), then by least
/// squares over the inliers until these are stable. Needs at least three finite pairs; the caller
/// checks for degenerate ones.
RobustFit robustFit(const PointPairs& pairs, const RobustFitOptions& options)
{
    const int n = pairs.size();
    RobustFit result;
    if (n >= kFewestForRejection) result.inliers = consensus(pairs, options);
    if (result.inliers.size() < 3)
    {
        result.inliers.resize(static_cast<std::size_t>(n));
        std::iota(result.inliers.begin(), result.inliers.end(), 0);
    }
    fit(result, pairs, result.inliers, options.scaling);
    for (int round = 0; round < 10 && n >= kFewestForRejection; ++round)
    {
        const double limit = options.outlierSigmas * noise(result, options.scaling);
        std::vector<int> next = within(result.residuals_m, limit);
        if (next.size() < 3 || next == result.inliers) break;
        result.inliers = std::move(next);
        fit(result, pairs, result.inliers, options.scaling);
    }
    result.noise_m = noise(result, options.scaling);
    return result;
}

constexpr int kEnoughPoints = 12;
constexpr double kLineRatio = 0.05;  ///< second over first standard deviation: below, a line
constexpr double kPlaneRatio = 0.1;  ///< third over first: below, a plane
constexpr double kMirrorRatio = 0.5; ///< mirrored noise over direct: below, wrong handedness

/// Standard deviations along the principal axes, largest first.
Eigen::Vector3d spread(const Eigen::Matrix3Xd& points)
{
    const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
    const base::SymmetricAxes<3> axes =
        base::symmetricAxes(Eigen::Matrix3d(centred * centred.transpose()));
    const double count = static_cast<double>(points.cols());
    return (axes.values.cwiseMax(0.0) / count).cwiseSqrt().reverse();
}

/// Error of the fit at r, to first order: e = t + w x (r - c) with c the pairs' centroid, Cov t =
/// sigma^2/n I and Cov w = sigma^2 A^-1, A = sum(|d|^2 I - d d^T), d = r_k - c (normal equations of
/// the rigid fit; its trace is the target registration error of Fitzpatrick, West, Maurer 1998).
/// Returns Cov e / sigma^2.
class ErrorModel
{
public:
    explicit ErrorModel(const Eigen::Matrix3Xd& points) :
        _centre(points.rowwise().mean()),
        _count(static_cast<double>(points.cols()))
    {
        const Eigen::Matrix3Xd d = points.colwise() - _centre;
        const Eigen::Matrix3d moments =
            d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose();
        _inverse = moments.inverse();
    }

    Eigen::Matrix3d at(const Eigen::Vector3d& r) const
    {
        const Eigen::Matrix3d lever = crossMatrix(r - _centre);
        return Eigen::Matrix3d::Identity() / _count + lever * _inverse * lever.transpose();
    }

private:
    Eigen::Vector3d _centre;
    double _count;
    Eigen::Matrix3d _inverse;
};

void warn(CalibrationReport& report, CalibrationProblem problem, const std::string& text)
{
    report.warnings.push_back({problem, text});
}

std::string unitWarning(double scale)
{
    const std::string text = fmt::format(
        "the world points have to be scaled by {:.4g} to fit the array points, ", scale);
    const std::string world = unitName(scale);
    const std::string array = unitName(1.0 / scale);
    if (!world.empty())
        return text + "so they are probably in " + world + " where metres are expected";
    if (!array.empty())
        return text + "so the array points are probably in " + array + " where metres are expected";
    return text +
           "and no common unit explains it: check both units, and the tracker's own calibration";
}

/// True if the world is mirrored: a similarity fit of the mirrored points is then far better. False
/// for coplanar points, which fit their mirror image as well as themselves.
bool mirrored(const PointPairs& pairs, const RobustFit& direct, const RobustFitOptions& options)
{
    PointPairs mirror = pairs;
    mirror.world.row(0) *= -1.0;
    const RobustFit other = robustFit(mirror, options);
    return other.inliers.size() >= direct.inliers.size() &&
           other.noise_m < kMirrorRatio * direct.noise_m;
}

/// Checks unit and handedness by a fit with scaling. Returns false if either is wrong.
bool checkScaleAndHand(CalibrationReport& report,
                       const PointPairs& pairs,
                       const CalibrationOptions& options)
{
    const RobustFitOptions similarity = {true, options.outlierSigmas, options.trials, options.seed};
    const RobustFit fit = robustFit(pairs, similarity);
    if (mirrored(pairs, fit, similarity))
    {
        warn(report,
             CalibrationProblem::WRONG_HANDEDNESS,
             "a mirrored world fits far better, so one of the two frames is left-handed: both must "
             "be "
             "right-handed (an axis negated, or two exchanged, in one of them)");
        return false;
    }
    const PointPairs kept = chosen(pairs, fit.inliers);
    report.scale = fit.scale;
    // Var s = sigma^2 / sum |d|^2 with d in world units, the normal equation of s alone.
    report.scaleError =
        fit.noise_m / (spread(kept.world).norm() * std::sqrt(static_cast<double>(kept.size())));
    const double off = std::abs(report.scale - 1.0);
    if (off <= options.scaleTolerance || off <= 3.0 * report.scaleError) return true;
    warn(report, CalibrationProblem::WRONG_UNIT, unitWarning(report.scale));
    return false;
}

void checkShape(CalibrationReport& report, const PointPairs& kept)
{
    const int n = kept.size();
    if (n < kEnoughPoints)
        warn(report,
             CalibrationProblem::FEW_POINTS,
             fmt::format(
                 "{} point pairs; take 12 or more, spread over the workspace and not in one plane",
                 n));
    const Eigen::Vector3d sigmas = spread(kept.world);
    if (sigmas[2] < kPlaneRatio * sigmas[0])
        warn(report,
             CalibrationProblem::COPLANAR,
             "the points lie nearly in one plane, so handedness can't be checked and errors away "
             "from "
             "it are larger; take 12 or more that do not");
}

void listOutliers(CalibrationReport& report)
{
    std::vector<std::string> list;
    for (std::size_t k = 0; k < report.outlier.size(); ++k)
    {
        if (!report.outlier[k]) continue;
        list.push_back(fmt::format(
            "{} ({:.1f} mm)", k + 1, 1e3 * report.residuals_m[static_cast<Eigen::Index>(k)]));
    }
    if (!list.empty())
        warn(report,
             CalibrationProblem::OUTLIERS,
             fmt::format("pairs left out as outliers: {}", fmt::join(list, ", ")));
}

void checkInput(const PointPairs& pairs, const CalibrationOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    if (pairs.array.cols() != pairs.world.cols())
        throw base::InputError(
            fmt::format("{} world points and {} array points; there must be as many of each",
                        pairs.world.cols(),
                        pairs.array.cols()));
    for (Eigen::Index k = 0; k < pairs.world.cols(); ++k)
        if (!pairs.world.col(k).allFinite() || !pairs.array.col(k).allFinite())
            throw base::InputError(
                fmt::format("point pair {} has a coordinate that is not finite", k + 1));
}

} // namespace

bool CalibrationOptions::isValid(std::string* error) const
{
    return base::RangeCheck("CalibrationOptions: ")
        .above("edge_m", edge_m, 0.0)
        .check(outlierSigmas > 0.0, "outlierSigmas", outlierSigmas, "above 0")
        .check(scaleTolerance > 0.0, "scaleTolerance", scaleTolerance, "above 0")
        .atLeast("trials", trials, 1)
        .passed(error);
}

bool CalibrationReport::has(CalibrationProblem problem) const
{
    return std::any_of(warnings.begin(),
                       warnings.end(),
                       [&](const CalibrationWarning& w) { return w.problem == problem; });
}

std::string CalibrationReport::text() const
{
    const auto out = static_cast<int>(std::count(outlier.begin(), outlier.end(), true));
    const auto all = static_cast<int>(outlier.size());
    std::string result = usable ? "calibrated from " : "not calibrated: ";
    result += fmt::format("{} of {} point pairs\n", all - out, all);
    if (usable)
    {
        double largest = 0.0;
        for (std::size_t k = 0; k < outlier.size(); ++k)
            if (!outlier[k]) largest = std::max(largest, residuals_m[static_cast<Eigen::Index>(k)]);
        result += fmt::format(
            "residuals: rms {:.2f} mm, largest {:.2f} mm\n", 1e3 * rms_m, 1e3 * largest);
        result += fmt::format("noise: {:.2f} mm a coordinate\n", 1e3 * noise_m);
        result += fmt::format("scale: {:.4f} +- {:.4f}\n", scale, scaleError);
        result += fmt::format(
            "likely error at the workspace's edge, {:.0f} mm from its centre: {:.2f} mm "
            "(median), {:.2f} mm (95 %)\n",
            1e3 * edge_m,
            1e3 * edgeErrorMedian_m,
            1e3 * edgeError95_m);
    }
    for (const CalibrationWarning& warning : warnings)
        result += "warning: " + warning.text + "\n";
    return result;
}

CalibrationReport calibrate(const PointPairs& pairs, const CalibrationOptions& options)
{
    checkInput(pairs, options);
    CalibrationReport report;
    const int n = pairs.size();
    report.edge_m = options.edge_m;
    report.outlier.assign(static_cast<std::size_t>(n), false);
    report.residuals_m = Eigen::VectorXd::Zero(n);
    if (n < 3)
    {
        warn(report,
             CalibrationProblem::TOO_FEW_POINTS,
             fmt::format(
                 "{} point pairs; take at least three, better 12 or more that are not in one plane",
                 n));
        return report;
    }
    RobustFit fit = robustFit(pairs, {false, options.outlierSigmas, options.trials, options.seed});
    PointPairs kept = chosen(pairs, fit.inliers);
    const Eigen::Vector3d all = spread(pairs.world);
    const Eigen::Vector3d sigmas = spread(kept.world);
    if (all[1] <= kLineRatio * all[0] || sigmas[1] <= kLineRatio * sigmas[0])
    {
        warn(report,
             CalibrationProblem::COLLINEAR,
             "the points lie on one line, so the rotation about it is undetermined; take 12 or "
             "more that are not in one plane");
        return report;
    }
    if (!checkScaleAndHand(report, pairs, options)) return report;

    report.usable = true;
    report.worldToArray.linear() = fit.linear;
    report.worldToArray.translation() = fit.offset;
    report.residuals_m = fit.residuals_m;
    report.outlier.assign(static_cast<std::size_t>(n), true);
    for (const int k : fit.inliers)
        report.outlier[static_cast<std::size_t>(k)] = false;
    report.noise_m = fit.noise_m;
    const int freedom = 3 * kept.size() - 6;
    report.rms_m = fit.noise_m * std::sqrt(freedom / static_cast<double>(kept.size()));
    const ErrorModel errors(kept.array);
    const PlaceError edge = placeError(
        worstAtRadius(options.edge_m, [&](const Eigen::Vector3d& r) { return errors.at(r); }),
        report.noise_m,
        freedom,
        options.seed);
    report.edgeErrorMedian_m = edge.median_m;
    report.edgeError95_m = edge.most95_m;
    checkShape(report, kept);
    listOutliers(report);
    return report;
}

} // namespace midair::bridge
