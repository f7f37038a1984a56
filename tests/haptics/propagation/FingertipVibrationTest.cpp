// The vibration under fingertips against a slow one, written here from the probe's signals.
#include "haptics/propagation/FingertipVibration.h"

#include "haptics/base/Units.h"
#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

TEST(FingertipVibration, SkinFeels220HzBest)
{
    EXPECT_DOUBLE_EQ(skinSensitivity(220.0), 1.0);
    EXPECT_NEAR(20.0 * std::log10(skinSensitivity(110.0)), -12.0, 0.1);
    EXPECT_NEAR(20.0 * std::log10(skinSensitivity(440.0)), -9.0, 0.1);
    EXPECT_EQ(skinSensitivity(0.0), 0.0);
}

TEST(FingertipVibration, WavesUpTo1000HzAreFelt)
{
    EXPECT_EQ(feltWaves(1, 1e-3), 0) << "a held field doesn't vibrate";
    EXPECT_EQ(feltWaves(2, 1e-3), 2);
    EXPECT_EQ(feltWaves(8, 1e-3), 8);
    EXPECT_EQ(feltWaves(2, 1e-4), 0) << "5000 Hz";
    EXPECT_EQ(feltWaves(64, 1.0), 256);
}

TEST(FingertipVibration, APadIsTheMeanOfItsPlaces)
{
    const Eigen::Matrix3Xd places = spherePoints(900, 0.03, {0.0, 0.0, 0.1}).positions;
    const auto pads = fingertipPads(places);
    ASSERT_GE(pads.rows(), 300);
    ASSERT_LE(pads.rows(), 400);
    const Eigen::MatrixXd shares = pads;
    for (Eigen::Index pad = 0; pad < pads.rows(); ++pad)
    {
        EXPECT_NEAR(shares.row(pad).sum(), 1.0, 1e-12);
        // A cap of the sphere: pi 7^2 of its 4 pi 30^2 mm^2.
        const auto count = (shares.row(pad).array() > 0.0).count();
        EXPECT_NEAR(static_cast<double>(count), 900.0 * 49.0 / 3600.0, 4.0);
    }
    EXPECT_EQ(fingertipPads(Eigen::Matrix3Xd(3, 0)).rows(), 0);
}

TEST(FingertipVibration, OfOneWaveEverywhereIsItsRms)
{
    RingingCourse course;
    course.mean.setConstant(5, 2.0);
    course.waves.setConstant(5, 2, {0.0, 0.0});
    course.waves.col(1).setConstant({0.3, 0.4});
    const auto pads = fingertipPads(1e-3 * Eigen::Matrix3Xd::Ones(3, 5));
    EXPECT_NEAR(
        fingertipVibration(pads, course, 2.0 / 110.0), 0.25 * 0.5 / std::sqrt(2.0) / 2.0, 1e-12);
    EXPECT_NEAR(fingertipVibration(pads, course, 2.0 / 220.0), 0.5 / std::sqrt(2.0) / 2.0, 1e-12);
    course.mean.setZero();
    EXPECT_EQ(fingertipVibration(pads, course, 1e-2), 0.0) << "silence";
}

// Samples of the probe, averaged over pads, and their Fourier transform, all written apart.
double slowVibration(const Eigen::Matrix3Xd& places,
                     const TransducerArray& array,
                     const std::vector<Eigen::VectorXcf>& fields,
                     double step_s)
{
    constexpr int kMoments = 200; // in a step
    const auto K = static_cast<int>(fields.size());
    DriveSchedule schedule;
    schedule.drives = fields;
    for (int k = 0; k < K; ++k)
        schedule.steps.push_back({k, 1.0, step_s});
    const PressureProbe probe(array, Medium(), schedule);
    ProbeOptions options;
    options.rate_Hz = kMoments / step_s;
    options.begin_s = 0.5 / options.rate_Hz;
    options.duration_s = K * step_s;
    const int N = options.samples();
    Eigen::MatrixXd square(N, places.cols());
    for (Eigen::Index l = 0; l < places.cols(); ++l)
        square.col(l) = probe.at(places.col(l), options).cwiseAbs2();
    double felt2 = 0.0, mean = 0.0;
    for (Eigen::Index pad = 0; pad < places.cols(); ++pad)
    {
        Eigen::VectorXd force = Eigen::VectorXd::Zero(N);
        int count = 0;
        for (Eigen::Index l = 0; l < places.cols(); ++l)
            if ((places.col(l) - places.col(pad)).norm() <= 0.007)
            {
                force += square.col(l);
                ++count;
            }
        force /= count;
        mean += force.mean() / static_cast<double>(places.cols());
        for (int h = 1; h / (K * step_s) < 1000.5; ++h)
        {
            std::complex<double> sum = 0.0;
            for (int t = 0; t < N; ++t)
                sum += force[t] * std::polar(2.0 / N, -base::kTwoPi * h * (t + 0.5) / N);
            const double f_Hz = h / (K * step_s);
            const double s =
                f_Hz < 220.0 ? std::pow(f_Hz / 220.0, 2.0) : std::pow(220.0 / f_Hz, 1.5);
            felt2 += 0.5 * s * s * std::norm(sum) / static_cast<double>(places.cols());
        }
    }
    return std::sqrt(felt2) / mean;
}

TEST(FingertipVibration, OfASurfaceIsThatOfTheProbe)
{
    TransducerArray array = TransducerArray::singleBoard();
    const Eigen::Matrix3Xd places = spherePoints(60, 0.012, {0.0, 0.0, 0.12}).positions;
    std::mt19937 random(2);
    std::uniform_real_distribution<float> angle(0.0f, static_cast<float>(base::kTwoPi));
    std::vector<Eigen::VectorXcf> fields;
    for (int k = 0; k < 3; ++k)
        fields.push_back(Eigen::VectorXcf::NullaryExpr(
            array.size(), [&] { return std::polar(1.0f, angle(random)); }));
    SurfaceStatisticsOptions options;
    options.offPoints = 0;
    for (const double ringing_s : {kT4010A1Ringing_s, 0.0})
        for (const double rate_Hz : {300.0, 1000.0})
        {
            array.ringing_s = ringing_s;
            options.fieldRate_Hz = rate_Hz;
            const double fast =
                surfaceStatistics(places, array, Medium(), fields, options).vibration;
            const double slow = slowVibration(places, array, fields, 1.0 / rate_Hz);
            EXPECT_NEAR(fast, slow, 0.01 * slow) << ringing_s << " " << rate_Hz;
            EXPECT_GT(slow, 0.02);
        }
    options.fieldRate_Hz = 0.0;
    EXPECT_EQ(surfaceStatistics(places, array, Medium(), fields, options).vibration, 0.0);
    options.fieldRate_Hz = 1000.0;
    EXPECT_EQ(surfaceStatistics(places, array, Medium(), {fields[0]}, options).vibration, 0.0);
}

} // namespace
} // namespace midair::haptics
