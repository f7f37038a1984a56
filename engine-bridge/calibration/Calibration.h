#pragma once

#include "engine-bridge/calibration/PointPairs.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{

/// What calibrate() is asked for; isValid() names the first setting that is out of its range.
struct CalibrationOptions
{
    double edge_m = 0.15;         ///< > 0; distance of the workspace's edge from the array's origin
    double outlierSigmas = 4.0;   ///< > 0; a pair farther off than this many sigmas is left out
    double scaleTolerance = 0.02; ///< > 0; a scale fit farther from 1 than this is warned of
    int trials = 1000;            ///< >= 1; triples tried where there are too many to try all
    std::uint64_t seed = 1;       ///< the same pairs and options give the same calibration

    bool isValid(std::string* error = nullptr) const;
};

enum class CalibrationProblem
{
    TOO_FEW_POINTS,   ///< under 3: nothing to fit
    COLLINEAR,        ///< the turn about their line is open
    WRONG_HANDEDNESS, ///< a mirrored world fits far better
    WRONG_UNIT,       ///< a scaled world fits, and its scale is not 1
    FEW_POINTS,       ///< under 12
    COPLANAR,         ///< handedness can't be checked, and errors off the plane are larger
    OUTLIERS          ///< pairs were left out
};

/// Something the user should know; the first four kinds make a calibration unusable.
struct CalibrationWarning
{
    CalibrationProblem problem;
    std::string text;
};

/// The rigid matrix from world to array, how well it is known, and what is wrong with the pairs.
struct CalibrationReport
{
    bool usable = false; ///< false: worldToArray must not be used
    Eigen::Isometry3d worldToArray = Eigen::Isometry3d::Identity(); ///< metres
    Eigen::VectorXd residuals_m; ///< n, |worldToArray world - array|, outliers' too
    std::vector<bool> outlier;   ///< n
    double rms_m = 0.0;          ///< of the residuals that were kept
    double noise_m = 0.0; ///< standard deviation a coordinate, unbiased: sqrt(sum r^2 / (3n - 6))
    double scale = 1.0;   ///< array over world, fitted apart; 1 where it can't be fitted
    double scaleError = 0.0;        ///< standard error of the same
    double edge_m = 0.0;            ///< from the options
    double edgeErrorMedian_m = 0.0; ///< at the worst spot of the workspace's edge: even odds
    double edgeError95_m = 0.0;     ///< 95 times in 100 the error there is below this
    std::vector<CalibrationWarning> warnings;

    bool has(CalibrationProblem problem) const;
    std::string text() const; ///< some lines for a person; pairs count from 1
};

/// Least-squares rigid motion (Umeyama 1991, without scaling) of the pairs that agree with one
/// another. Which do is found by least median of squares over triples (Rousseeuw 1984), so up to
/// nearly half of them may be wrong; fewer than six pairs are all kept. The error at the edge
/// follows from the fit's covariance (see Calibration.cpp). Throws base::InputError for options out
/// of range and for pairs that are not finite.
CalibrationReport calibrate(const PointPairs& pairs, const CalibrationOptions& options = {});

} // namespace midair::bridge
