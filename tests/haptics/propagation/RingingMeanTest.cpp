// Means of what rings against the closed form of unrelated fields, against a recursion over single
// transducers written here, and against the probe, which knows every delay.
#include "haptics/propagation/RingingMean.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

constexpr double kTau_s = 190e-6;

std::vector<Eigen::VectorXcf> randomFields(int count, Eigen::Index m, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> angle(0.0f, static_cast<float>(base::kTwoPi));
    std::vector<Eigen::VectorXcf> fields;
    for (int k = 0; k < count; ++k)
        fields.push_back(
            Eigen::VectorXcf::NullaryExpr(m, [&] { return std::polar(1.0f, angle(random)); }));
    return fields;
}

// Two fields with the overlap Re<q0, q1>/m = rho.
std::vector<Eigen::VectorXcf> twoFields(double rho)
{
    std::vector<Eigen::VectorXcf> fields{Eigen::VectorXcf::Ones(1000), {}};
    fields[1] = fields[0];
    const auto turn = std::polar(1.0f, static_cast<float>(std::acos(rho)));
    fields[1].head(500) *= turn;
    fields[1].tail(500) *= std::conj(turn);
    return fields;
}

std::vector<PatternStep> once(std::size_t fields)
{
    std::vector<PatternStep> steps;
    for (std::size_t k = 0; k < fields; ++k)
        steps.push_back({static_cast<int>(k), 1.0});
    return steps;
}

double share(const std::vector<Eigen::VectorXcf>& fields, double step_s, double ringing_s)
{
    const RadiatedPower power = radiatedPower(fields, once(fields.size()), step_s, ringing_s);
    return power.ringing_mean / power.steady_mean;
}

// a_k = q_k + (a_{k-1} - q_k) e^{-T/tau}, from silence until it repeats; |a|^2 by Simpson's rule.
double slowShare(const std::vector<Eigen::VectorXcf>& fields, double step_s, double ringing_s)
{
    constexpr int kPanels = 200;
    Eigen::VectorXcd a = Eigen::VectorXcd::Zero(fields[0].size());
    double ringing = 0.0, steady = 0.0;
    const int rounds =
        2 + static_cast<int>(40.0 * ringing_s / step_s / static_cast<double>(fields.size()));
    for (int round = 0; round < rounds; ++round)
    {
        ringing = steady = 0.0;
        for (const Eigen::VectorXcf& field : fields)
        {
            const Eigen::VectorXcd q = field.cast<std::complex<double>>();
            for (int s = 0; s <= kPanels && round + 1 == rounds; ++s)
            {
                const double weight = s == 0 || s == kPanels ? 1.0 : s % 2 == 1 ? 4.0 : 2.0;
                const double left = std::exp(-step_s * s / kPanels / ringing_s);
                ringing += weight * (q + (a - q) * left).squaredNorm() / (3.0 * kPanels);
            }
            steady += q.squaredNorm();
            a = q + (a - q) * std::exp(-step_s / ringing_s);
        }
    }
    return ringing / steady;
}

TEST(RadiatedPower, SwitchingCostsWhatTheFormulaSays)
{
    for (const double rho : {0.0, 0.5, 0.9})
        for (const double T : {1e-3, 2e-3})
        {
            const double x = std::exp(-T / kTau_s);
            const double lost = (1.0 - rho) * kTau_s / T * (1.0 - x) * (1.0 - x);
            EXPECT_NEAR(1.0 - share(twoFields(rho), T, kTau_s), lost, 0.01 * lost)
                << rho << " " << T;
        }
    EXPECT_NEAR(share(randomFields(8, 4000, 1), 1e-3, kTau_s), 0.81, 0.01);
    EXPECT_NEAR(share(randomFields(8, 4000, 1), 2e-3, kTau_s), 0.905, 0.01);
}

TEST(RadiatedPower, ShortStepsAreTheRecursion)
{
    for (const double T : {25e-6, 1e-4, 2e-4, 5e-4, 1e-3})
        for (const int count : {2, 5})
        {
            const auto fields = randomFields(count, 300, 7);
            const double slow = slowShare(fields, T, kTau_s);
            EXPECT_NEAR(share(fields, T, kTau_s), slow, 1e-5) << T << " " << count;
        }
    EXPECT_NEAR(share(randomFields(3, 300, 2), 1e-3, 0.01),
                slowShare(randomFields(3, 300, 2), 1e-3, 0.01),
                1e-5);
    EXPECT_DOUBLE_EQ(share(randomFields(3, 300, 2), 1e-3, 0.0), 1.0);
    EXPECT_NEAR(share(randomFields(1, 300, 2), 1e-3, kTau_s), 1.0, 1e-6);
}

// The swing of |a|^2 at f where a = 0.5 + 0.1 cos: 2 * 0.5 * 0.1 of the envelope's swing.
TEST(RadiatedPower, AModulationLosesWhatAResonanceTakes)
{
    for (const double f_Hz : {200.0, 500.0, 1000.0})
    {
        std::vector<PatternStep> steps;
        for (int k = 0; k < 400; ++k)
            steps.push_back({0, 0.5 + 0.1 * std::cos(base::kTwoPi * k / 400)});
        const RadiatedPower power =
            radiatedPower({Eigen::VectorXcf::Ones(1)}, steps, 1.0 / (400 * f_Hz), kTau_s, f_Hz);
        const double formula = 1.0 / std::hypot(1.0, base::kTwoPi * f_Hz * kTau_s);
        EXPECT_NEAR(power.steady_swing, 0.1, 1e-4);
        EXPECT_NEAR(power.ringing_swing / power.steady_swing, formula, 0.002) << f_Hz;
    }
}

TEST(RadiatedPower, WhatIsOutOfRangeIsRefused)
{
    EXPECT_THROW(radiatedPower({}, {{0, 1.0}}, 1e-3, 0.0), base::InputError);
    EXPECT_THROW(radiatedPower(randomFields(1, 3, 1), {}, 1e-3, 0.0), base::InputError);
    EXPECT_THROW(radiatedPower(randomFields(1, 3, 1), once(1), 0.0, 0.0), base::InputError);
    EXPECT_THROW(radiatedPower(randomFields(1, 3, 1), once(1), 1e-3, NAN), base::InputError);
    EXPECT_THROW(radiatedPower(randomFields(1, 3, 1), once(1), 1e-3, -1e-6), base::InputError);
}

// Foci and random fields, at their places and off them; the probe sums all delays exactly.
TEST(RingingMean, IsTheMeanOfTheProbe)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    Eigen::Matrix3Xd points(3, 4);
    points.col(0) << 0.0, 0.0, 0.0;
    points.col(1) << 0.03, 0.0, 0.01;
    points.col(2) << 0.05, 0.04, -0.03;
    points.col(3) << -0.02, 0.0, 0.0;
    std::vector<Eigen::VectorXcf> fields = randomFields(2, array.size(), 3);
    for (const int l : {0, 1, 2})
        fields.push_back(
            referencePropagationMatrix(points.col(l), array, medium)
                .row(0)
                .unaryExpr([](const std::complex<double>& g) { return std::conj(g) / std::abs(g); })
                .transpose()
                .cast<std::complex<float>>());
    for (const double T : {1e-4, 3e-4, 1e-3, 5e-3})
    {
        const Eigen::VectorXd fast = ringingMeanSquare(points, array, medium, fields, T, 2);
        DriveSchedule schedule;
        schedule.drives = fields;
        for (int k = 0; k < 5; ++k)
            schedule.steps.push_back({k, 1.0, T});
        const PressureProbe probe(array, medium, schedule);
        ProbeOptions options;
        options.rate_Hz = 400e3;
        options.duration_s = 5.0 * T;
        for (int l = 0; l < 4; ++l)
        {
            const double slow = probe.at(points.col(l), options).squaredNorm() /
                                static_cast<double>(options.samples());
            EXPECT_NEAR(fast[l] / slow, 1.0, 0.002) << T << " " << l;
        }
    }
}

// The waves against a discrete Fourier transform of the probe's signal, sampled at the middles of
// short intervals, from the same time on.
TEST(RingingMean, WavesAreThoseOfTheProbe)
{
    TransducerArray array = TransducerArray::singleBoard();
    Eigen::Matrix3Xd points(3, 2);
    points.col(0) << 0.0, 0.0, 0.1;
    points.col(1) << 0.02, -0.01, 0.16;
    const std::vector<Eigen::VectorXcf> fields = randomFields(3, array.size(), 3);
    constexpr int kWaves = 4;
    for (const double ringing_s : {kTau_s, 0.0})
        for (const double T : {3e-4, 1e-3})
        {
            array.ringing_s = ringing_s;
            const RingingCourse course = ringingCourse(points, array, Medium(), fields, T, kWaves);
            DriveSchedule schedule;
            schedule.drives = fields;
            for (int k = 0; k < 3; ++k)
                schedule.steps.push_back({k, 1.0, T});
            ProbeOptions options;
            options.rate_Hz = 1e6;
            options.begin_s = 0.5e-6;
            options.duration_s = 3.0 * T;
            for (int l = 0; l < 2; ++l)
            {
                const Eigen::VectorXd square =
                    PressureProbe(array, Medium(), schedule).at(points.col(l), options).cwiseAbs2();
                for (int h = 1; h <= kWaves; ++h)
                {
                    std::complex<double> wave = 0.0;
                    for (Eigen::Index t = 0; t < square.size(); ++t)
                        wave += square[t] *
                                std::polar(2.0 / static_cast<double>(square.size()),
                                           -base::kTwoPi * h * (static_cast<double>(t) + 0.5) /
                                               static_cast<double>(square.size()));
                    EXPECT_LT(std::abs(course.waves(l, h - 1) - wave),
                              (ringing_s > 0.0 ? 0.006 : 0.02) * course.mean[l])
                        << ringing_s << " " << T << " " << h;
                }
            }
        }
    EXPECT_EQ(ringingCourse(points, array, Medium(), {fields[0]}, 1e-3, 2).waves,
              Eigen::MatrixXcd::Zero(2, 2));
}

TEST(RingingMean, OfOneFieldAndWithoutRingingIsTheSteadyOne)
{
    TransducerArray array = TransducerArray::singleBoard();
    const Eigen::Matrix3Xd points = Eigen::Vector3d(0.01, 0.0, 0.15);
    const auto fields = randomFields(3, array.size(), 5);
    const std::vector<Eigen::VectorXcf> one{fields[0]};
    EXPECT_EQ(ringingMeanSquare(points, array, Medium(), one, 1e-3),
              meanSquarePressure(points, array, Medium(), one));
    EXPECT_NE(ringingMeanSquare(points, array, Medium(), fields, 1e-3),
              meanSquarePressure(points, array, Medium(), fields));
    array.ringing_s = 0.0;
    EXPECT_EQ(ringingMeanSquare(points, array, Medium(), fields, 1e-3),
              meanSquarePressure(points, array, Medium(), fields));
    array.ringing_s = kTau_s;
    EXPECT_NEAR(ringingMeanSquare(points, array, Medium(), fields, 100.0)[0] /
                    meanSquarePressure(points, array, Medium(), fields)[0],
                1.0,
                1e-4)
        << "held for long";
    EXPECT_THROW(ringingMeanSquare(points, array, Medium(), fields, 0.0), base::InputError);
    EXPECT_THROW(ringingMeanSquare(points, array, Medium(), randomFields(2, 3, 1), 1e-3),
                 base::InputError);
}

TEST(RingingMean, OverlapsAreTheQuadraticFormOfThePower)
{
    for (const int K : {1, 2, 3, 8})
        for (const double step_s : {0.2e-3, 1e-3, 5e-3})
        {
            const std::vector<Eigen::VectorXcf> fields = randomFields(K, 50, 3);
            const Eigen::VectorXd M = ringingOverlaps(K, step_s, kTau_s);
            std::complex<double> mean = 0.0;
            for (std::size_t k = 0; k < fields.size(); ++k)
                for (std::size_t l = 0; l < fields.size(); ++l)
                    mean += M[static_cast<Eigen::Index>((k + fields.size() - l) % fields.size())] *
                            std::complex<double>(fields[k].dot(fields[l])) / double(K);
            const double power =
                radiatedPower(fields, once(fields.size()), step_s, kTau_s).ringing_mean;
            EXPECT_NEAR(mean.real(), power, 1e-5 * power) << K << " " << step_s;
            EXPECT_NEAR(mean.imag(), 0.0, 1e-5 * power);
            EXPECT_NEAR(M.sum(), 1.0, 1e-12);
        }
}

TEST(RingingMean, WithoutRingingNothingOverlaps)
{
    EXPECT_EQ(ringingOverlaps(4, 1e-3, 0.0), Eigen::VectorXd(Eigen::VectorXd::Unit(4, 0)));
    EXPECT_THROW(ringingOverlaps(0, 1e-3, 0.0), base::InputError);
    EXPECT_THROW(ringingOverlaps(2, 0.0, kTau_s), base::InputError);
}

} // namespace
} // namespace midair::haptics
