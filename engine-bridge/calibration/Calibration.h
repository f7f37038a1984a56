#pragma once

#include "engine-bridge/calibration/PointPairs.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Options of calibrate(); isValid() names the first setting that is out of its range.
struct CalibrationOptions
{
    double edge_m = 0.15;       ///< > 0; distance of the workspace's edge from the array's origin
    double outlierSigmas = 4.0; ///< > 0; pairs with larger residuals, in sigmas, are excluded
    /// > 0; a fitted scale that differs from 1 by more than this and 3 standard errors is a
    /// WRONG_UNIT
    double scaleTolerance = 0.02;
    int trials = 1000;      ///< >= 1; limit of the triples of pairs to try
    std::uint64_t seed = 1; ///< the same pairs and options give the same calibration

    bool isValid(std::string* error = nullptr) const;
};

/// The kinds of problems with point pairs.
enum class CalibrationProblem
{
    TOO_FEW_POINTS,   ///< under 3: nothing to fit
    COLLINEAR,        ///< the rotation about the points' line is undetermined
    WRONG_HANDEDNESS, ///< a mirrored world fits far better
    WRONG_UNIT,       ///< a scaled world fits, with a scale other than 1
    FEW_POINTS,       ///< under 12 pairs
    COPLANAR,         ///< handedness can't be checked, and errors off the plane are larger
    OUTLIERS          ///< pairs were excluded
};

/// A problem to report; the first four kinds make a calibration unusable.
struct CalibrationWarning
{
    CalibrationProblem problem;
    std::string text;
};

/// The result of calibrate(): the rigid matrix from world to array, its accuracy, and warnings
/// about the pairs.
struct CalibrationReport
{
    bool usable = false; ///< false: worldToArray must not be used
    Eigen::Isometry3d worldToArray = Eigen::Isometry3d::Identity(); ///< metres
    Eigen::VectorXd residuals_m; ///< n, |worldToArray world - array|, including outliers
    std::vector<bool> outlier;   ///< n
    double rms_m = 0.0;          ///< of the residuals of pairs that are not outliers
    /// standard deviation per coordinate, unbiased: sqrt(sum r^2 / (3n - 6))
    double noise_m = 0.0;
    double scale = 1.0;      ///< array over world, from a separate fit; 1 if it can't be fitted
    double scaleError = 0.0; ///< standard error of the scale
    double edge_m = 0.0;     ///< from the options
    double edgeErrorMedian_m = 0.0; ///< median error at the worst place at the distance edge_m
    double edgeError95_m = 0.0;     ///< 95 % quantile of the error there
    std::vector<CalibrationWarning> warnings;

    bool has(CalibrationProblem problem) const;
    std::string text() const; ///< a few lines of text for the user; pairs are numbered from 1
};

/// Fits a rigid motion by least squares (Umeyama 1991, without scaling) to the mutually consistent
/// pairs. Finds these by least median of squares over triples (Rousseeuw 1984), so that nearly half
/// of the pairs may be wrong; with fewer than six pairs it keeps all. The error at the edge follows
/// from the fit's covariance (see Calibration.cpp). Throws base::InputError for options out of
/// range and for pairs that are not finite.
CalibrationReport calibrate(const PointPairs& pairs, const CalibrationOptions& options = {});

} // namespace midair::bridge
