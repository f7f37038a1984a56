#include "tests/referee/Surface.h"

#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/surface/SurfaceSampler.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace midair::referee
{

namespace
{

// As the documentation of SurfaceStatisticsOptions and FieldMonitor has them.
constexpr double kSpacing = 0.18; // of samples, wavelengths
constexpr double kReach = 1.1;    // of a control point, wavelengths
constexpr int kPlacesOff = 4000;
constexpr double kRadiusOff_m = 0.09;
constexpr int kTriesPerPlace = 20;

bool isNear(const Eigen::Vector3d& place, const Eigen::Matrix3Xd& others, double reach_m)
{
    for (Eigen::Index l = 0; l < others.cols(); ++l)
        if ((others.col(l) - place).norm() <= reach_m) return true;
    return false;
}

Eigen::Matrix3Xd feltSamples(const Recorded& recorded, const Update& update, double wavelength_m)
{
    haptics::SamplerOptions options;
    options.spacing_m = kSpacing * wavelength_m;
    options.maxPoints = 100000;
    Eigen::Matrix3Xd samples = haptics::sampleSurface(*recorded.mesh, options).positions;
    Eigen::Index kept = 0;
    for (Eigen::Index l = 0; l < samples.cols(); ++l)
    {
        const Eigen::Vector3d place = update.pose * Eigen::Vector3d(samples.col(l));
        for (const Part& part : update.parts)
            if (isNear(place, part.points.positions, kReach * wavelength_m))
            {
                samples.col(kept++) = place;
                break;
            }
    }
    return samples.leftCols(kept);
}

// Evenly in a ball around the middle of the samples, a wavelength from all of them: the draws of
// seed 1.
Eigen::Matrix3Xd placesOff(const Eigen::Matrix3Xd& samples, double wavelength_m)
{
    std::mt19937_64 draws(1);
    const auto coordinate = [&draws] { return std::ldexp(double(draws() >> 11U), -52) - 1.0; };
    const Eigen::Vector3d middle = samples.rowwise().mean();
    Eigen::Matrix3Xd places(3, kPlacesOff);
    Eigen::Index found = 0;
    for (int k = 0; k < kTriesPerPlace * kPlacesOff && found < kPlacesOff; ++k)
    {
        Eigen::Vector3d step;
        for (double& one : step)
            one = coordinate();
        if (step.norm() > 1.0) continue;
        const Eigen::Vector3d place = middle + kRadiusOff_m * step;
        if (!isNear(place, samples, wavelength_m)) places.col(found++) = place;
    }
    return places.leftCols(found);
}

// p_rms^2 / (rho c^2) alpha with alpha 2, the mean over the fields.
std::vector<double> radiationPressures(const Eigen::Matrix3Xd& places,
                                       const Recorded& recorded,
                                       const std::vector<Eigen::VectorXcd>& fields)
{
    constexpr Eigen::Index kAtOnce = 256;
    const double c = recorded.medium.soundSpeed();
    const double perSquare =
        1.0 / (recorded.medium.density() * c * c) / static_cast<double>(fields.size());
    std::vector<double> all_Pa;
    for (Eigen::Index first = 0; first < places.cols(); first += kAtOnce)
    {
        const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(
            places.middleCols(first, std::min(kAtOnce, places.cols() - first)),
            recorded.array,
            recorded.medium);
        Eigen::VectorXd squares = Eigen::VectorXd::Zero(G.rows());
        for (const Eigen::VectorXcd& q : fields)
            squares += (G * q).cwiseAbs2();
        for (const double square : squares)
            all_Pa.push_back(perSquare * square);
    }
    return all_Pa;
}

double meanOf(const std::vector<double>& values)
{
    double sum = 0.0;
    for (const double value : values)
        sum += value;
    return sum / static_cast<double>(values.size());
}

double squaresAbout(double middle, const std::vector<double>& values)
{
    double sum = 0.0;
    for (const double value : values)
        sum += (value - middle) * (value - middle);
    return sum;
}

// Of ascending values, the k-th of n being at (k - 1)/(n - 1).
double percentile(const std::vector<double>& ascending, double share)
{
    const double place = share * static_cast<double>(ascending.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, ascending.size() - 1);
    return ascending[below] +
           (place - static_cast<double>(below)) * (ascending[above] - ascending[below]);
}

} // namespace

std::map<std::string, Truth> surfaceFigures(const Recorded& recorded,
                                            const Update& update,
                                            const std::vector<Eigen::VectorXcd>& fields)
{
    const double wavelength_m = recorded.medium.wavelength(recorded.array.frequency_Hz);
    const Eigen::Matrix3Xd samples = feltSamples(recorded, update, wavelength_m);
    std::vector<double> on_Pa = radiationPressures(samples, recorded, fields);
    const std::vector<double> off_Pa =
        radiationPressures(placesOff(samples, wavelength_m), recorded, fields);
    std::sort(on_Pa.begin(), on_Pa.end());
    const auto n = static_cast<double>(on_Pa.size());
    const auto off = static_cast<double>(off_Pa.size());
    const double mean_Pa = meanOf(on_Pa);
    const double offMean_Pa = meanOf(off_Pa);
    std::map<std::string, Truth> figures;
    const auto set = [&figures](const char* name, double value) {
        figures[std::string("surface.") + name] = {value, value, false};
    };
    figures["surface.samples"] = {n, n, true};
    set("mean_Pa", mean_Pa);
    set("coefficientOfVariation", std::sqrt(squaresAbout(mean_Pa, on_Pa) / n) / mean_Pa);
    set("percentile1", percentile(on_Pa, 0.01) / mean_Pa);
    set("percentile5", percentile(on_Pa, 0.05) / mean_Pa);
    set("percentile10", percentile(on_Pa, 0.10) / mean_Pa);
    set("percentile95", percentile(on_Pa, 0.95) / mean_Pa);
    set("offMean_Pa", offMean_Pa);
    set("contrast", mean_Pa / offMean_Pa);
    set("contrastError",
        mean_Pa / offMean_Pa * std::sqrt(squaresAbout(offMean_Pa, off_Pa) / (off - 1.0) / off) /
            offMean_Pa);
    return figures;
}

} // namespace midair::referee
