#include "haptics/propagation/SurfaceStatistics.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>
#include <complex>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// Even over a sphere.
Eigen::Matrix3Xd sphere(int n, double radius_m)
{
    Eigen::Matrix3Xd r(3, n);
    for (int l = 0; l < n; ++l)
    {
        const double z = 1.0 - (2.0 * l + 1.0) / n;
        const double phi = 2.399963229728653 * l; // the golden angle
        r.col(l) << std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi),
            z;
    }
    return radius_m * r;
}

Eigen::VectorXcf focusedAt(const Eigen::Vector3d& focus, const TransducerArray& array)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(focus, array, Medium());
    return G.row(0).conjugate().cwiseQuotient(G.row(0).cwiseAbs()).cast<std::complex<float>>();
}

std::string messageOf(const std::function<void()>& call)
{
    try
    {
        call();
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

} // namespace

TEST(SurfaceStatistics, OfValuesThatAreKnown)
{
    // 0, 1, .. 100: mean 50, variance (101^2 - 1)/12 = 850, the p-th percentile is p.
    Eigen::VectorXd on = Eigen::VectorXd::LinSpaced(101, 0.0, 100.0).reverse();
    const SurfaceStatistics statistics = statisticsOf(on, Eigen::Vector3d(10.0, 20.0, 30.0));
    EXPECT_EQ(statistics.samples, 101);
    EXPECT_NEAR(statistics.mean_Pa, 50.0, 1e-12);
    EXPECT_NEAR(statistics.coefficientOfVariation, std::sqrt(850.0) / 50.0, 1e-12);
    EXPECT_NEAR(statistics.percentile1, 1.0 / 50.0, 1e-12);
    EXPECT_NEAR(statistics.percentile10, 10.0 / 50.0, 1e-12);
    EXPECT_EQ(statistics.offSamples, 3);
    EXPECT_NEAR(statistics.offMean_Pa, 20.0, 1e-12);
    EXPECT_NEAR(statistics.contrast, 2.5, 1e-12);
    // The standard deviation of 10, 20, 30 is 10, their mean's 10/sqrt(3): 0.2887 of 20.
    EXPECT_NEAR(statistics.contrastError, 2.5 * 10.0 / std::sqrt(3.0) / 20.0, 1e-12);
}

TEST(SurfaceStatistics, OfOneValueAndOfSilence)
{
    const SurfaceStatistics one =
        statisticsOf(Eigen::VectorXd::Constant(1, 3.0), Eigen::VectorXd());
    EXPECT_EQ(one.coefficientOfVariation, 0.0);
    EXPECT_EQ(one.percentile1, 1.0);
    EXPECT_EQ(one.percentile10, 1.0);
    EXPECT_EQ(one.contrast, 0.0);
    EXPECT_EQ(one.contrastError, 0.0);
    // One place tells nothing about how places differ.
    EXPECT_EQ(statisticsOf(Eigen::VectorXd::Ones(2), Eigen::VectorXd::Ones(1)).contrastError, 0.0);
    const SurfaceStatistics silent =
        statisticsOf(Eigen::VectorXd::Zero(10), Eigen::VectorXd::Zero(10));
    EXPECT_EQ(silent.mean_Pa, 0.0);
    EXPECT_EQ(silent.coefficientOfVariation, 0.0);
    EXPECT_EQ(silent.percentile1, 0.0);
    EXPECT_EQ(silent.contrast, 0.0);
}

TEST(SurfaceStatistics, RandomPhasesAreSpeckle)
{
    // Waves of random phase from all round are fully developed speckle: the intensity is
    // exponential, so that cv = 1 and the p-th percentile is -ln(1 - p); K independent fields in
    // turn leave 1/sqrt(K). About (90 mm / (wavelength/2))^2 = 400 independent spots on a sphere of
    // 45 mm: 5 % on cv is one sigma, hence 15 %.
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::vector<Eigen::VectorXcf> cycle;
    unsigned state = 1;
    for (int k = 0; k < 4; ++k)
    {
        Eigen::VectorXcf q(array.size());
        for (int i = 0; i < array.size(); ++i)
        {
            state = state * 1664525u + 1013904223u;
            q[i] = std::polar(1.0f, 2.9258361e-9f * static_cast<float>(state >> 1));
        }
        cycle.push_back(q);
    }
    SurfaceStatisticsOptions options;
    options.offPoints = 400;
    const Eigen::Matrix3Xd surface = sphere(1500, 0.045);
    const SurfaceStatistics one =
        surfaceStatistics(surface, array, Medium(), {cycle.front()}, options);
    EXPECT_NEAR(one.coefficientOfVariation, 1.0, 0.15);
    EXPECT_NEAR(one.percentile1, -std::log(0.99), 0.01);
    EXPECT_NEAR(one.percentile10, -std::log(0.9), 0.04);
    const SurfaceStatistics four = surfaceStatistics(surface, array, Medium(), cycle, options);
    EXPECT_NEAR(four.coefficientOfVariation, 0.5, 0.1);
}

TEST(SurfaceStatistics, ContrastOfAFocus)
{
    // Samples close to a focus against those far from it, each evaluated apart from the function
    // under test.
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Vector3d focus(0.01, -0.02, 0.015);
    const Eigen::VectorXcf q = focusedAt(focus, array);
    const Eigen::Matrix3Xd surface = sphere(50, 0.5e-3).colwise() + focus;
    SurfaceStatisticsOptions options;
    options.offPoints = 300;
    options.threads = 2;
    const SurfaceStatistics statistics = surfaceStatistics(surface, array, Medium(), {q}, options);
    const double peak_Pa = referencePropagationMatrix(focus, array, Medium()).cwiseAbs().sum();
    // Half a millimetre off the focus it has lost a few percent.
    EXPECT_NEAR(statistics.mean_Pa / radiationPressure(peak_Pa, Medium()), 1.0, 0.06);
    EXPECT_LT(statistics.mean_Pa, radiationPressure(peak_Pa, Medium()));
    EXPECT_LT(statistics.coefficientOfVariation, 0.05);
    EXPECT_EQ(statistics.offSamples, 300);
    EXPECT_GT(statistics.contrast, 30.0);
    EXPECT_NEAR(statistics.contrast, statistics.mean_Pa / statistics.offMean_Pa, 1e-9);

    // Half the fields silent: half the mean pressure on and off, the rest as it was.
    const SurfaceStatistics half = surfaceStatistics(
        surface, array, Medium(), {q, Eigen::VectorXcf::Zero(array.size())}, options);
    EXPECT_NEAR(half.mean_Pa / statistics.mean_Pa, 0.5, 1e-9);
    EXPECT_NEAR(half.contrast / statistics.contrast, 1.0, 1e-9);
    EXPECT_NEAR(half.percentile10, statistics.percentile10, 1e-9);
}

TEST(SurfaceStatistics, PlacesOffTheSurfaceKeepTheirDistance)
{
    // A sphere of 30 mm in a ball of 35 mm leaves only its inside; with 50 mm to keep nothing.
    const TransducerArray array = TransducerArray::singleBoard();
    const Eigen::Matrix3Xd surface = sphere(800, 0.03);
    const std::vector<Eigen::VectorXcf> cycle = {Eigen::VectorXcf::Ones(array.size())};
    SurfaceStatisticsOptions options;
    options.offRadius_m = 0.035;
    options.offPoints = 200;
    // The inside beyond a wavelength is (30 - 8.6)^3/35^3 = 23 % of the ball, the ball 52 % of its
    // cube: found.
    EXPECT_EQ(surfaceStatistics(surface, array, Medium(), cycle, options).offSamples, 200);
    options.offDistance_m = 0.05;
    const SurfaceStatistics none = surfaceStatistics(surface, array, Medium(), cycle, options);
    EXPECT_EQ(none.offSamples, 0);
    EXPECT_EQ(none.contrast, 0.0);
    // The same seed, the same places.
    options.offDistance_m = 0.0;
    const double first = surfaceStatistics(surface, array, Medium(), cycle, options).offMean_Pa;
    EXPECT_EQ(surfaceStatistics(surface, array, Medium(), cycle, options).offMean_Pa, first);
    options.seed = 2;
    EXPECT_NE(surfaceStatistics(surface, array, Medium(), cycle, options).offMean_Pa, first);
}

TEST(SurfaceStatistics, ContrastErrorIsTheScatterOverSeeds)
{
    // A standard deviation of 60 draws scatters by 1/sqrt(2 60) = 9 %, and a single draw's estimate
    // by as much again, since a few foci hold much of the variance; the mean of the estimates
    // hardly does. 30 % is three sigma.
    constexpr int kSeeds = 60;
    const TransducerArray array = TransducerArray::octagonalPrism();
    Eigen::VectorXcf q = Eigen::VectorXcf::Zero(array.size());
    unsigned state = 3;
    for (int i = 0; i < array.size(); ++i)
    {
        state = state * 1664525u + 1013904223u;
        q[i] = std::polar(1.0f, 2.9258361e-9f * static_cast<float>(state >> 1));
    }
    SurfaceStatisticsOptions options;
    options.offPoints = 200;
    Eigen::VectorXd contrast(kSeeds);
    double told = 0.0;
    for (int k = 0; k < kSeeds; ++k)
    {
        options.seed = 1 + static_cast<std::uint64_t>(k);
        const SurfaceStatistics statistics =
            surfaceStatistics(sphere(300, 0.03), array, Medium(), {q}, options);
        contrast[k] = statistics.contrast;
        told += statistics.contrastError / kSeeds;
    }
    const double scatter =
        std::sqrt((contrast.array() - contrast.mean()).square().sum() / (kSeeds - 1));
    EXPECT_NEAR(told / scatter, 1.0, 0.3);
}

TEST(SurfaceStatistics, DefaultPlacesTellContrastToThreePercent)
{
    // Foci on a sphere, all at once, as a solver's field has them; of 1000 places the contrast
    // would be uncertain by 4 to 5 %.
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Matrix3Xd surface = sphere(100, 0.03);
    const Eigen::VectorXcd z =
        referencePropagationMatrix(surface, array, Medium()).adjoint().rowwise().sum();
    const Eigen::VectorXcf q =
        z.cwiseQuotient(z.cwiseAbs().cast<std::complex<double>>()).cast<std::complex<float>>();
    const SurfaceStatistics statistics = surfaceStatistics(surface, array, Medium(), {q});
    EXPECT_GT(statistics.contrastError, 0.0);
    EXPECT_LT(statistics.contrastError, 0.03 * statistics.contrast);
    SurfaceStatisticsOptions few;
    few.offPoints = 1000;
    const SurfaceStatistics rough = surfaceStatistics(surface, array, Medium(), {q}, few);
    EXPECT_GT(rough.contrastError, 0.03 * rough.contrast);
}

TEST(SurfaceStatistics, WhatCannotBeJudgedIsRefused)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const Medium medium;
    const std::vector<Eigen::VectorXcf> cycle = {Eigen::VectorXcf::Ones(array.size())};
    Eigen::Matrix3Xd surface = sphere(10, 0.03);
    const auto message = [&](const SurfaceStatisticsOptions& options)
    { return messageOf([&] { surfaceStatistics(surface, array, medium, cycle, options); }); };
    SurfaceStatisticsOptions options;
    options.alpha = 3.0;
    EXPECT_EQ(message(options), "surface statistics: alpha is 3; it must be within 1 .. 2");
    options = {};
    options.offRadius_m = 0.0;
    EXPECT_EQ(message(options), "surface statistics: offRadius_m is 0; it must be above 0");
    options = {};
    options.offDistance_m = -1.0;
    EXPECT_EQ(message(options), "surface statistics: offDistance_m is -1; it must be at least 0");
    options = {};
    options.offPoints = -1;
    EXPECT_EQ(message(options), "surface statistics: offPoints is -1; it must be at least 0");
    options = {};
    options.threads = 0;
    EXPECT_EQ(message(options), "surface statistics: threads is 0; it must be at least 1");
    EXPECT_EQ(messageOf([&] { surfaceStatistics(surface, array, medium, {}); }),
              "the cycle has no fields; there must be at least one");
    surface(0, 3) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(message({}), "a sample of the surface is not finite");
    surface.resize(3, 0);
    EXPECT_EQ(message({}), "the surface has no samples; there must be at least one");
    EXPECT_EQ(
        messageOf([] { statisticsOf(Eigen::Vector2d(1.0, std::nan("")), Eigen::VectorXd()); }),
        "a radiation pressure is not finite; positions and activations must be");
}
