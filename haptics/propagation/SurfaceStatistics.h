#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"

#include <osgMidair/FieldFigures>

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Options for measuring a played field over a surface.
struct SurfaceStatisticsOptions
{
    double alpha = 2.0; ///< 1 .. 2; factor of the radiation pressure
    /// > 0; places off the surface are at most this far from the middle of the samples ..
    double offRadius_m = 0.09;
    /// >= 0; .. and at least this far from every sample; 0: one wavelength
    double offDistance_m = 0.0;
    /// >= 0; number of places off the surface; 0: no contrast. The field there is speckle around
    /// foci, so contrastError is about 1.4/sqrt(offPoints) of the contrast.
    int offPoints = 4000;
    /// >= 0; fields per second of a cycle, for the ringing figures; 0: without ringing
    double fieldRate_Hz = 0.0;
    std::uint64_t seed = 1; ///< seed of the places off the surface
    int threads = 1;        ///< >= 1
    base::StopToken stop;   ///< on its request Stopped is thrown

    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// Returns the statistics of radiation pressures on (\a on_Pa, n) and off (\a off_Pa, any number) a
/// surface. Percentiles are interpolated linearly, with the k-th of n sorted values at (k - 1)/(n -
/// 1). Throws InputError if \a on_Pa is empty or a value is not finite.
SurfaceStatistics statisticsOf(const Eigen::VectorXd& on_Pa, const Eigen::VectorXd& off_Pa);

/// Returns the radiation pressure in Pa at \a points (3 x n), averaged over \a cycle, whose fields
/// play for equal times. Throws InputError for an empty cycle, Stopped if \a stop requests it.
Eigen::VectorXd meanRadiationPressure(const Eigen::Matrix3Xd& points,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      const std::vector<Eigen::VectorXcf>& cycle,
                                      double alpha = 2.0,
                                      int threads = 1,
                                      const base::StopToken& stop = {});

/// Measures the fields of \a cycle (K >= 1 times m activations, as the device plays them) at \a
/// surface (3 x n, metres, array frame). The samples should be evenly spread, at most a fifth of a
/// wavelength apart, because the field between control points is speckle of about half a
/// wavelength. Throws InputError for an empty surface or cycle and for invalid options, Stopped if
/// the options' token requests it.
SurfaceStatistics surfaceStatistics(const Eigen::Matrix3Xd& surface,
                                    const TransducerArray& array,
                                    const Medium& medium,
                                    const std::vector<Eigen::VectorXcf>& cycle,
                                    const SurfaceStatisticsOptions& options = {});

/// Returns those of \a samples (3 x n) within \a reach_m of one of \a points (3 x m): the touchable
/// part of a surface. Throws Stopped if \a stop requests it.
Eigen::Matrix3Xd samplesNear(const Eigen::Matrix3Xd& samples,
                             const Eigen::Matrix3Xd& points,
                             double reach_m,
                             const base::StopToken& stop = {});

} // namespace midair::haptics
