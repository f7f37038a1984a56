#pragma once

#include "engine-bridge/calibration/PointPairs.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// Options of robustFit().
struct RobustFitOptions
{
    bool scaling = false;       ///< also fit a uniform scale
    double outlierSigmas = 4.0; ///< > 0; pairs with larger residuals, in sigmas, are outliers
    int trials = 1000;          ///< >= 1; the most triples to try
    std::uint64_t seed = 1;
};

/// The map array = linear world + offset that fits the pairs which agree with one another.
struct RobustFit
{
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity(); ///< rotation times scale
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();     ///< metres
    double scale = 1.0;
    Eigen::VectorXd residuals_m; ///< n
    std::vector<bool> inlier;    ///< n
    int inliers = 0;
    double noise_m = 0.0; ///< standard deviation per coordinate over the inliers
};

/// Fits by least median of squares over triples (all, or random ones by seed), then by least
/// squares over the inliers until these stay the same. Needs at least three finite pairs; the
/// caller checks for degenerate ones.
RobustFit robustFit(const PointPairs& pairs, const RobustFitOptions& options);

} // namespace midair::bridge
