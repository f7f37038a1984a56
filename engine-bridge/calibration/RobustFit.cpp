#include "engine-bridge/calibration/RobustFit.h"

#include "haptics/base/SmallMatrices.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace midair::bridge
{

namespace
{

constexpr int kFewestForRejection = 6;  ///< fewer pairs don't show which one is wrong
constexpr double kFinestNoise_m = 1e-7; ///< so that rounding makes no outliers of exact pairs

using Triple = std::array<int, 3>;

void fit(RobustFit& result, const PointPairs& pairs, const std::vector<int>& chosen, bool scaling)
{
    const auto count = static_cast<Eigen::Index>(chosen.size());
    Eigen::Matrix3Xd world(3, count);
    Eigen::Matrix3Xd array(3, count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
        world.col(k) = pairs.world.col(chosen[static_cast<std::size_t>(k)]);
        array.col(k) = pairs.array.col(chosen[static_cast<std::size_t>(k)]);
    }
    const Eigen::Matrix4d motion = base::nearestMotion(world, array, scaling);
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

/// The h-th smallest residual, h = floor(n/2) + floor((p + 1)/2) with p = 3 pairs in a trial fit,
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
double noise(const RobustFit& result, const std::vector<int>& chosen, bool scaling)
{
    double sum = 0.0;
    for (const int k : chosen)
        sum += result.residuals_m[k] * result.residuals_m[k];
    const int freedom = 3 * static_cast<int>(chosen.size()) - (scaling ? 7 : 6);
    return std::max(kFinestNoise_m, std::sqrt(sum / std::max(1, freedom)));
}

/// The pairs that agree with the fit to the best triple.
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
    // The median of the length of a Gaussian 3-vector is 1.538 sigma; the factor after it is
    // Rousseeuw's for small samples.
    const double sigma =
        std::max(kFinestNoise_m, bestMedian / 1.538 * (1.0 + 5.0 / std::max(1, n - 3)));
    return within(best.residuals_m, options.outlierSigmas * sigma);
}

} // namespace

RobustFit robustFit(const PointPairs& pairs, const RobustFitOptions& options)
{
    const int n = pairs.size();
    std::vector<int> chosen;
    if (n >= kFewestForRejection) chosen = consensus(pairs, options);
    if (static_cast<int>(chosen.size()) < 3)
    {
        chosen.clear();
        for (int k = 0; k < n; ++k)
            chosen.push_back(k);
    }
    RobustFit result;
    fit(result, pairs, chosen, options.scaling);
    for (int round = 0; round < 10 && n >= kFewestForRejection; ++round)
    {
        const double limit = options.outlierSigmas * noise(result, chosen, options.scaling);
        std::vector<int> next = within(result.residuals_m, limit);
        if (static_cast<int>(next.size()) < 3 || next == chosen) break;
        chosen = std::move(next);
        fit(result, pairs, chosen, options.scaling);
    }
    result.noise_m = noise(result, chosen, options.scaling);
    result.inliers = static_cast<int>(chosen.size());
    result.inlier.assign(static_cast<std::size_t>(n), false);
    for (const int k : chosen)
        result.inlier[static_cast<std::size_t>(k)] = true;
    return result;
}

} // namespace midair::bridge
