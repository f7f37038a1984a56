#include "haptics/propagation/SurfaceStatistics.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/FingertipVibration.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace midair::haptics
{

namespace
{

// Returns places spread evenly in the ball around the samples' middle, at least \a distance_m from
// every sample. Generates its own uniform numbers, so that a seed gives the same places with every
// standard library.
Eigen::Matrix3Xd placesOff(const Eigen::Matrix3Xd& surface,
                           double distance_m,
                           const SurfaceStatisticsOptions& options)
{
    // Bounds the search: a ball filled by the surface has few such places or none.
    constexpr int kTriesPerPlace = 20;
    const Eigen::Vector3d middle = surface.rowwise().mean();
    std::mt19937_64 random(options.seed);
    const auto uniform = [&random]
    { return 2.0 * (static_cast<double>(random() >> 11U) * 0x1p-53) - 1.0; };
    Eigen::Matrix3Xd places(3, options.offPoints);
    int found = 0;
    for (int t = 0; t < kTriesPerPlace * options.offPoints && found < options.offPoints; ++t)
    {
        options.stop.throwIfRequested();
        const double x = uniform();
        const double y = uniform();
        const double z = uniform();
        const Eigen::Vector3d step(x, y, z);
        if (step.squaredNorm() > 1.0) continue;
        const Eigen::Vector3d place = middle + options.offRadius_m * step;
        const double nearest2 = (surface.colwise() - place).colwise().squaredNorm().minCoeff();
        if (nearest2 >= distance_m * distance_m) places.col(found++) = place;
    }
    return places.leftCols(found);
}

// Copies the figures with ringing from \a ringing, where they are the ordinary ones.
void ringAs(const SurfaceStatistics& ringing, SurfaceStatistics& statistics)
{
    statistics.ringingMean_Pa = ringing.mean_Pa;
    statistics.ringingCoefficientOfVariation = ringing.coefficientOfVariation;
    statistics.ringingPercentile1 = ringing.percentile1;
    statistics.ringingContrast = ringing.contrast;
}

} // namespace

bool SurfaceStatisticsOptions::isValid(std::string* error) const
{
    return base::RangeCheck()
        .within("alpha", alpha, 1.0, 2.0)
        .above("offRadius_m", offRadius_m, 0.0)
        .atLeast("offDistance_m", offDistance_m, 0.0)
        .atLeast("offPoints", offPoints, 0)
        .atLeast("fieldRate_Hz", fieldRate_Hz, 0.0)
        .atLeast("threads", threads, 1)
        .passed(error);
}

SurfaceStatistics statisticsOf(const Eigen::VectorXd& on_Pa, const Eigen::VectorXd& off_Pa)
{
    if (on_Pa.size() == 0)
        throw base::InputError("the surface has no samples; there must be at least one");
    if (!on_Pa.allFinite() || !off_Pa.allFinite())
        throw base::InputError(
            "a radiation pressure is not finite; positions and activations must be");

    SurfaceStatistics statistics;
    statistics.samples = static_cast<int>(on_Pa.size());
    statistics.offSamples = static_cast<int>(off_Pa.size());
    statistics.mean_Pa = on_Pa.mean();
    if (statistics.mean_Pa > 0.0)
    {
        const double mean = statistics.mean_Pa;
        const std::vector<double> values(on_Pa.begin(), on_Pa.end());
        statistics.coefficientOfVariation =
            std::sqrt((on_Pa.array() - mean).square().mean()) / mean;
        statistics.percentile1 = base::percentile(values, 0.01) / mean;
        statistics.percentile5 = base::percentile(values, 0.05) / mean;
        statistics.percentile10 = base::percentile(values, 0.10) / mean;
        statistics.percentile95 = base::percentile(values, 0.95) / mean;
    }
    if (off_Pa.size() > 0) statistics.offMean_Pa = off_Pa.mean();
    if (statistics.offMean_Pa > 0.0)
    {
        statistics.contrast = statistics.mean_Pa / statistics.offMean_Pa;
        // d contrast / contrast = -d offMean / offMean, and the mean of n independent values has
        // the variance sum (x - mean)^2 / (n - 1) / n.
        const double n = static_cast<double>(off_Pa.size());
        const double squares = (off_Pa.array() - statistics.offMean_Pa).square().sum();
        if (n > 1.0)
            statistics.contrastError =
                statistics.contrast * std::sqrt(squares / (n - 1.0) / n) / statistics.offMean_Pa;
    }
    ringAs(statistics, statistics);
    return statistics;
}

Eigen::VectorXd meanRadiationPressure(const Eigen::Matrix3Xd& points,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      const std::vector<Eigen::VectorXcf>& cycle,
                                      double alpha,
                                      int threads,
                                      const base::StopToken& stop)
{
    // Averages |p|^2, to which the radiation pressure is proportional.
    return meanSquarePressure(points, array, medium, cycle, threads, stop) *
           radiationPressure(1.0, medium, alpha);
}

Eigen::Matrix3Xd samplesNear(const Eigen::Matrix3Xd& samples,
                             const Eigen::Matrix3Xd& points,
                             double reach_m,
                             const base::StopToken& stop)
{
    Eigen::Matrix3Xd near(3, samples.cols());
    Eigen::Index count = 0;
    base::StopLook look(stop);
    for (const auto& sample : samples.colwise())
    {
        look.turn();
        if (points.cols() > 0 &&
            (points.colwise() - sample).colwise().squaredNorm().minCoeff() <= reach_m * reach_m)
            near.col(count++) = sample;
    }
    near.conservativeResize(3, count);
    return near;
}

SurfaceStatistics surfaceStatistics(const Eigen::Matrix3Xd& surface,
                                    const TransducerArray& array,
                                    const Medium& medium,
                                    const std::vector<Eigen::VectorXcf>& cycle,
                                    const SurfaceStatisticsOptions& options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError("surface statistics: " + error);
    if (surface.cols() == 0)
        throw base::InputError("the surface has no samples; there must be at least one");
    if (!surface.allFinite()) throw base::InputError("a sample of the surface is not finite");

    const double distance_m =
        options.offDistance_m > 0.0 ? options.offDistance_m : medium.wavelength(array.frequency_Hz);
    const Eigen::Matrix3Xd off = placesOff(surface, distance_m, options);
    SurfaceStatistics statistics = statisticsOf(
        meanRadiationPressure(
            surface, array, medium, cycle, options.alpha, options.threads, options.stop),
        meanRadiationPressure(
            off, array, medium, cycle, options.alpha, options.threads, options.stop));
    if (cycle.size() < 2 || options.fieldRate_Hz == 0.0) return statistics;
    const double step_s = 1.0 / options.fieldRate_Hz;
    const auto K = static_cast<int>(cycle.size());
    const auto course = [&](const Eigen::Matrix3Xd& points, int waves)
    {
        return ringingCourse(
            points, array, medium, cycle, step_s, waves, options.threads, options.stop);
    };
    const RingingCourse on = course(surface, feltWaves(K, step_s));
    if (array.ringing_s > 0.0)
    {
        const double unit = radiationPressure(1.0, medium, options.alpha);
        ringAs(statisticsOf(unit * on.mean, unit * course(off, 0).mean), statistics);
    }
    statistics.vibration = fingertipVibration(fingertipPads(surface), on, K * step_s);
    return statistics;
}

} // namespace midair::haptics
