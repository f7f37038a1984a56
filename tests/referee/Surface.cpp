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

/// |p|^2 at a place over a turn: its mean, and the amplitudes of its first waves.
struct Rung
{
    double mean = 0.0;
    std::vector<std::complex<double>> waves;
};

// The same with ringing, and with the time that sound takes: delays in bins of 1 us, and the square
// of the pressure at the middle of each. Waves up to 1000 Hz.
Rung ringingSquareAt(const Eigen::Vector3d& place,
                     const Eigen::RowVectorXcd& G,
                     const Recorded& recorded,
                     const std::vector<Eigen::VectorXcd>& fields)
{
    constexpr double kBin_s = 1e-6;
    const auto K = static_cast<Eigen::Index>(fields.size());
    const Eigen::RowVectorXd delay_s =
        (recorded.array.positions.colwise() - place).colwise().norm() /
        recorded.medium.soundSpeed();
    const double first_s = delay_s.minCoeff();
    const auto bins = static_cast<Eigen::Index>((delay_s.maxCoeff() - first_s) / kBin_s) + 1;
    Eigen::MatrixXcd arriving = Eigen::MatrixXcd::Zero(K, bins);
    for (Eigen::Index i = 0; i < G.size(); ++i)
        for (Eigen::Index k = 0; k < K; ++k)
            arriving(k, static_cast<Eigen::Index>((delay_s[i] - first_s) / kBin_s)) +=
                G[i] * fields[static_cast<std::size_t>(k)][i];
    const auto step = std::max<Eigen::Index>(1, std::lround(1.0 / recorded.fieldRate_Hz / kBin_s));
    const Eigen::Index period = std::max<Eigen::Index>(1, K * step);
    const double left = std::exp(-kBin_s / recorded.array.ringing_s);
    const double half = std::exp(-0.5 * kBin_s / recorded.array.ringing_s);
    std::complex<double> S = 0.0, E = 0.0;
    Rung rung;
    rung.waves.resize(
        static_cast<std::size_t>(1000.0 * kBin_s * static_cast<double>(period) + 1e-9));
    // From silence: after some rounds all is as in the round before.
    const Eigen::Index rounds =
        2 +
        static_cast<Eigen::Index>(30.0 * recorded.array.ringing_s / kBin_s + double(bins)) / period;
    for (Eigen::Index t = 0; t < rounds * period; ++t)
    {
        for (Eigen::Index bin = t % step; bin < bins && bin <= t; bin += step)
        {
            const Eigen::Index k = (t - bin) / step;
            std::complex<double> change = arriving(k % K, bin);
            if (k > 0) change -= arriving((k - 1) % K, bin);
            S += change;
            E -= change;
        }
        if (t >= (rounds - 1) * period)
        {
            const double square = std::norm(S + E * half) / static_cast<double>(period);
            const double turn =
                2.0 * M_PI * (static_cast<double>(t) + 0.5 + first_s / kBin_s) / double(period);
            rung.mean += square;
            for (std::size_t h = 0; h < rung.waves.size(); ++h)
                rung.waves[h] += 2.0 * square * std::polar(1.0, -turn * double(h + 1));
        }
        E *= left;
    }
    return rung;
}

std::vector<Rung> ringingSquares(const Eigen::Matrix3Xd& places,
                                 const Recorded& recorded,
                                 const std::vector<Eigen::VectorXcd>& fields)
{
    std::vector<Rung> all;
    for (Eigen::Index l = 0; l < places.cols(); ++l)
        all.push_back(ringingSquareAt(
            places.col(l),
            haptics::referencePropagationMatrix(places.col(l), recorded.array, recorded.medium)
                .row(0),
            recorded,
            fields));
    return all;
}

std::vector<double> ringingPressures(const std::vector<Rung>& all, const Recorded& recorded)
{
    const double c = recorded.medium.soundSpeed();
    std::vector<double> all_Pa;
    for (const Rung& rung : all)
        all_Pa.push_back(rung.mean / (recorded.medium.density() * c * c));
    return all_Pa;
}

// Pads of 7 mm around every place, or evenly chosen ones of more than 400; waves weigh as
// Verrillo's thresholds say.
double vibrationOf(const Eigen::Matrix3Xd& places, const std::vector<Rung>& all, double period_s)
{
    const Eigen::Index stride = (places.cols() + 399) / 400;
    double felt2 = 0.0, mean = 0.0, pads = 0.0;
    for (Eigen::Index pad = 0; pad < places.cols(); pad += stride, pads += 1.0)
    {
        double count = 0.0, force = 0.0;
        std::vector<std::complex<double>> waves(all.front().waves.size());
        for (Eigen::Index l = 0; l < places.cols(); ++l)
        {
            if ((places.col(l) - places.col(pad)).norm() > 0.007) continue;
            const Rung& rung = all[static_cast<std::size_t>(l)];
            count += 1.0;
            force += rung.mean;
            for (std::size_t h = 0; h < waves.size(); ++h)
                waves[h] += rung.waves[h];
        }
        mean += force / count;
        for (std::size_t h = 0; h < waves.size(); ++h)
        {
            const double octaves = std::log2(double(h + 1) / period_s / 220.0);
            const double weight =
                octaves < 0.0 ? std::exp2(2.0 * octaves) : std::exp2(-1.5 * octaves);
            felt2 += 0.5 * std::norm(weight * waves[h] / count);
        }
    }
    return std::sqrt(felt2 / pads) / (mean / pads);
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

/// Pressures on a surface, ascending, and off it.
struct OnAndOff
{
    const std::vector<double>&on_Pa, &off_Pa;
};

void setRinging(std::map<std::string, Truth>& figures, const OnAndOff& all)
{
    const double mean_Pa = meanOf(all.on_Pa);
    const auto set = [&figures](const char* name, double value) {
        figures[std::string("surface.ringing") + name] = {value, value, false};
    };
    set("Mean_Pa", mean_Pa);
    set("CoefficientOfVariation",
        std::sqrt(squaresAbout(mean_Pa, all.on_Pa) / double(all.on_Pa.size())) / mean_Pa);
    set("Percentile1", percentile(all.on_Pa, 0.01) / mean_Pa);
    set("Contrast", mean_Pa / meanOf(all.off_Pa));
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
    setRinging(figures, {on_Pa, off_Pa});
    set("vibration", 0.0);
    if (fields.size() < 2 || recorded.array.ringing_s == 0.0) return figures;
    const std::vector<Rung> rung = ringingSquares(samples, recorded, fields);
    set("vibration", vibrationOf(samples, rung, double(fields.size()) / recorded.fieldRate_Hz));
    std::vector<double> ringing_Pa = ringingPressures(rung, recorded);
    std::sort(ringing_Pa.begin(), ringing_Pa.end());
    setRinging(figures,
               {ringing_Pa,
                ringingPressures(ringingSquares(placesOff(samples, wavelength_m), recorded, fields),
                                 recorded)});
    return figures;
}

} // namespace midair::referee
