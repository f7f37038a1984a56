#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace midair::haptics
{

/// How a played field is measured over a surface; isValid() names the first setting that is out of
/// its range.
struct SurfaceStatisticsOptions
{
    double alpha = 2.0;         ///< 1 .. 2; of the radiation pressure
    double offRadius_m = 0.09;  ///< > 0; off the surface is within this of the samples' middle ..
    double offDistance_m = 0.0; ///< >= 0; .. and at least this from every sample; 0: a wavelength
    int offPoints = 1000;       ///< >= 0; 0: no contrast
    std::uint64_t seed = 1;     ///< of the places off the surface
    int threads = 1;            ///< 1 ..
    base::StopToken stop;       ///< where it asks for that, Stopped is thrown

    bool isValid(std::string* error = nullptr) const;
};

/// What a hand would find on a surface, averaged over the cycle of fields that is played.
struct SurfaceStatistics
{
    int samples = 0;
    double mean_Pa = 0.0;                ///< radiation pressure
    double coefficientOfVariation = 0.0; ///< standard deviation over mean; 0 where the mean is 0
    double percentile1 = 0.0;            ///< first percentile over the mean; likewise
    double percentile5 = 0.0;            ///< likewise
    double percentile10 = 0.0;           ///< likewise
    double percentile95 = 0.0;           ///< likewise
    int offSamples = 0;                  ///< places found off the surface
    double offMean_Pa = 0.0;             ///< radiation pressure there
    double contrast = 0.0; ///< mean_Pa / offMean_Pa; 0 where there is nothing off the surface
};

/// A number of a SurfaceStatistics: its name wherever it is shown.
struct SurfaceFigureRow
{
    const char* name; ///< with its unit
    std::variant<int SurfaceStatistics::*, double SurfaceStatistics::*> value;
};

inline const std::vector<SurfaceFigureRow> kSurfaceFigures = {
    {"samples", &SurfaceStatistics::samples},
    {"mean_Pa", &SurfaceStatistics::mean_Pa},
    {"coefficientOfVariation", &SurfaceStatistics::coefficientOfVariation},
    {"percentile1", &SurfaceStatistics::percentile1},
    {"percentile5", &SurfaceStatistics::percentile5},
    {"percentile10", &SurfaceStatistics::percentile10},
    {"percentile95", &SurfaceStatistics::percentile95},
    {"offMean_Pa", &SurfaceStatistics::offMean_Pa},
    {"contrast", &SurfaceStatistics::contrast},
};

/// The statistics of \a on_Pa (n) and \a off_Pa (any number), radiation pressures on and off a
/// surface. Percentiles are linear between the sorted values: the k-th of n stands at (k - 1)/(n -
/// 1). Throws InputError where \a on_Pa is empty or a value is not finite.
SurfaceStatistics statisticsOf(const Eigen::VectorXd& on_Pa, const Eigen::VectorXd& off_Pa);

/// Radiation pressure in Pa at \a points (3 x n), averaged over \a cycle, each field being played
/// for the same time. Throws InputError for an empty cycle, Stopped where \a stop asks for it.
Eigen::VectorXd meanRadiationPressure(const Eigen::Matrix3Xd& points,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      const std::vector<Eigen::VectorXcf>& cycle,
                                      double alpha = 2.0,
                                      int threads = 1,
                                      const base::StopToken& stop = {});

/// Measures the fields \a cycle (K >= 1 times m activations, as the device plays them) on \a
/// surface (3 x n, metres, in the array frame). Its samples are spread evenly, a fifth of a
/// wavelength apart or closer, since the field between control points is speckle of about half a
/// wavelength. Throws InputError for an empty surface or cycle and for invalid options, Stopped
/// where the options' token asks for it.
SurfaceStatistics surfaceStatistics(const Eigen::Matrix3Xd& surface,
                                    const TransducerArray& array,
                                    const Medium& medium,
                                    const std::vector<Eigen::VectorXcf>& cycle,
                                    const SurfaceStatisticsOptions& options = {});

/// Those of \a samples (3 x n) that are within \a reach_m of one of \a points (3 x m): the part of
/// a surface that is to be felt. Throws Stopped where \a stop asks for it.
Eigen::Matrix3Xd samplesNear(const Eigen::Matrix3Xd& samples,
                             const Eigen::Matrix3Xd& points,
                             double reach_m,
                             const base::StopToken& stop = {});

} // namespace midair::haptics
