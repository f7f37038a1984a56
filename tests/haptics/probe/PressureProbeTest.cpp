// The pressure over time against closed forms, and against a slow sum over all switches of all
// transducers that is written here.
#include "haptics/probe/PressureProbe.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
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

using Complex = std::complex<double>;

constexpr double kTau_s = 190e-6;

TransducerArray one()
{
    TransducerArray array;
    array.positions = Eigen::Vector3d::Zero();
    array.normals = Eigen::Vector3d::UnitZ();
    array.board = {0};
    return array;
}

// Silence, then each of \a drives for \a each_s; the last is held.
DriveSchedule inTurn(std::vector<Eigen::VectorXcf> drives, double each_s)
{
    DriveSchedule schedule;
    schedule.repeats = false;
    for (std::size_t k = 0; k < drives.size(); ++k)
        schedule.steps.push_back({static_cast<int>(k), 1.0, each_s});
    schedule.drives = std::move(drives);
    return schedule;
}

Eigen::VectorXcf drive(std::complex<float> q)
{
    return Eigen::VectorXcf::Constant(1, q);
}

Eigen::VectorXcf focus(const TransducerArray& array, const Eigen::Vector3d& at)
{
    return referencePropagationMatrix(at, array, Medium())
        .row(0)
        .unaryExpr([](const Complex& g) { return std::conj(g) / std::abs(g); })
        .transpose()
        .cast<std::complex<float>>();
}

ProbeOptions from(double begin_s, double rate_Hz, double duration_s)
{
    ProbeOptions options;
    options.begin_s = begin_s;
    options.rate_Hz = rate_Hz;
    options.duration_s = duration_s;
    return options;
}

// Each transducer by itself, each switch after the other, as the formula has it.
Complex slowly(const TransducerArray& array,
               const DriveSchedule& schedule,
               const Eigen::Vector3d& point,
               double time_s)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(point, array, Medium());
    Complex p = 0.0;
    for (int i = 0; i < array.size(); ++i)
    {
        const double heard_s =
            time_s - (array.positions.col(i) - point).norm() / Medium().soundSpeed();
        Complex a = 0.0;
        double begin_s = schedule.begin_s;
        for (std::size_t k = 0; k < schedule.steps.size() && begin_s <= heard_s; ++k)
        {
            const ScheduledDrive& step = schedule.steps[k];
            const Complex q = step.amplitude * Complex(schedule.drives[std::size_t(step.drive)][i]);
            const bool isLast = k + 1 == schedule.steps.size();
            const double end_s = isLast ? heard_s : std::min(heard_s, begin_s + step.duration_s);
            a = q + (a - q) * std::exp(-(end_s - begin_s) / array.ringing_s);
            begin_s += step.duration_s;
        }
        p += G(0, i) * a;
    }
    return p;
}

TEST(PressureProbe, HearsAReflectionLater)
{
    TransducerArray array = one();
    array.ringing_s = 0.0;
    const Eigen::Vector3d point(0.0, 0.0, 0.2);
    const double direct_s = 0.2 / Medium().soundSpeed(), late_s = 0.6 / Medium().soundSpeed();
    const Complex free =
        PressureProbe(array, Medium(), inTurn({drive(1.0f)}, 0.01)).steadyAt(point)[0];
    Reflector wall;
    wall.position = {0.0, 0.0, 0.4}; // the wave comes back after 0.6 m
    wall.accuracy_mm = 0.1;
    array.reflectors = {wall};
    const PressureProbe probe(array, Medium(), inTurn({drive(1.0f)}, 0.01));
    const Complex both = probe.steadyAt(point)[0];
    EXPECT_GT(std::abs(both - free), 0.1 * std::abs(free));
    const auto at = [&](double time_s) { return probe.at(point, from(time_s, 1e6, 1e-6))[0]; };
    EXPECT_EQ(at(direct_s - 1e-5), Complex(0.0));
    EXPECT_NEAR(std::abs(at(direct_s + 1e-5) - free), 0.0, 1e-9 * std::abs(free));
    EXPECT_NEAR(std::abs(at(late_s - 1e-5) - free), 0.0, 1e-9 * std::abs(free));
    EXPECT_NEAR(std::abs(at(late_s + 1e-5) - both), 0.0, 1e-9 * std::abs(free));
}

TEST(PressureProbe, OneTransducerComesOnAndGoesOff)
{
    const TransducerArray array = one();
    const Eigen::Vector3d point(0.0, 0.0, 0.2);
    const double delay_s = 0.2 / Medium().soundSpeed();
    const double on_s = 0.01;
    const PressureProbe probe(array, Medium(), inTurn({drive(1.0f), drive(0.0f)}, on_s));
    const double P1 = std::norm(probe.steadyAt(point)[0]);
    // Times at which the square of 1 - e^{-t/tau} is 10, 50, 90 and 99 %.
    for (const auto& [share, time_us] :
         {std::pair{0.1, 72.2}, {0.5, 233.3}, {0.9, 564.5}, {0.99, 1006.5}})
    {
        const double t = time_us * 1e-6;
        const double formula = std::pow(1.0 - std::exp(-t / kTau_s), 2);
        EXPECT_NEAR(formula, share, 0.001);
        const Complex p = probe.at(point, from(delay_s + t, 1e6, 1e-6))[0];
        EXPECT_NEAR(std::norm(p) / P1, formula, 1e-9) << t;
        const Complex after = probe.at(point, from(delay_s + on_s + t, 1e6, 1e-6))[0];
        EXPECT_NEAR(std::norm(after) / P1, std::exp(-2.0 * t / kTau_s), 1e-9) << t;
    }
    EXPECT_EQ(probe.at(point, from(delay_s - 1e-6, 1e6, 1e-6))[0], Complex(0.0)) << "not yet there";
}

TEST(PressureProbe, APhaseStepDipsWhereTheFormulaSays)
{
    const Eigen::Vector3d point(0.0, 0.0, 0.2);
    const double delay_s = 0.2 / Medium().soundSpeed();
    for (const double angle : {0.5, 1.5, 2.5, base::kPi})
    {
        const auto turned = std::polar(1.0f, static_cast<float>(angle));
        const PressureProbe probe(one(), Medium(), inTurn({drive(1.0f), drive(turned)}, 0.01));
        const double p1_Pa = std::abs(probe.steadyAt(point)[0]);
        const Eigen::VectorXd p_Pa =
            probe.at(point, from(delay_s + 0.01, 1e6, 1e-3)).cwiseAbs() / p1_Pa;
        int least = 0;
        EXPECT_NEAR(p_Pa.minCoeff(&least), std::fabs(std::cos(0.5 * angle)), 0.005);
        EXPECT_NEAR(least * 1e-6, kTau_s * std::log(2.0), 2e-6);
    }
}

TEST(PressureProbe, AFocusAndWhatIsOffItAreTheSlowSum)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const PressureProbe probe(
        array, Medium(), inTurn({focus(array, {0, 0, 0}), focus(array, {0.02, 0.01, 0.0})}, 0.004));
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.02, 0.01, 0), Eigen::Vector3d(0.05, 0, 0.03)})
    {
        const ProbeOptions options = from(0.0005, 20e3, 0.006);
        const Eigen::VectorXcd p_Pa = probe.at(point, options);
        ASSERT_EQ(p_Pa.size(), 120);
        double largest_Pa = 0.0, off_Pa = 0.0;
        for (int k = 0; k < 120; k += 3)
        {
            const Complex slow =
                slowly(array,
                       inTurn({focus(array, {0, 0, 0}), focus(array, {0.02, 0.01, 0.0})}, 0.004),
                       point,
                       options.begin_s + k / options.rate_Hz);
            largest_Pa = std::max(largest_Pa, std::abs(slow));
            off_Pa = std::max(off_Pa, std::abs(slow - p_Pa[k]));
        }
        EXPECT_LT(off_Pa, 1e-9 * largest_Pa);
        EXPECT_GT(largest_Pa, 100.0);
    }
}

// In the octagon's middle the nearest sound takes 0.68 ms and the farthest 0.83 ms, so that steps
// of 0.1 ms overtake each other's last arrivals.
TEST(PressureProbe, SwitchesOnTheirWayTogetherAreTheSlowSum)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::vector<Eigen::VectorXcf> drives;
    for (int k = 0; k < 30; ++k)
        drives.push_back(focus(array, {0.002 * k, 0.0, 0.01}));
    DriveSchedule schedule = inTurn(drives, 1e-4);
    for (std::size_t k = 0; k < schedule.steps.size(); k += 3)
        schedule.steps[k].amplitude = 0.3;
    const Eigen::Vector3d point(0.03, 0.01, 0.0);
    const ProbeOptions options = from(-0.0001, 20e3, 0.005);
    const Eigen::VectorXcd p_Pa = PressureProbe(array, Medium(), schedule).at(point, options);
    for (int k = 0; k < options.samples(); k += 5)
    {
        const Complex slow = slowly(array, schedule, point, options.begin_s + k / options.rate_Hz);
        EXPECT_LT(std::abs(slow - p_Pa[k]), 1e-6 * p_Pa.cwiseAbs().maxCoeff()) << k;
    }
}

TEST(PressureProbe, WithoutRingingTheSteadyFieldsComeBitForBit)
{
    TransducerArray array = TransducerArray::singleBoard();
    std::vector<Eigen::VectorXcf> drives;
    for (int k = 0; k < 3; ++k)
        drives.push_back(focus(array, {0.01 * k, 0.0, 0.15}));
    DriveSchedule schedule = inTurn(drives, 0.002);
    schedule.repeats = true;
    const Eigen::Vector3d point(0.004, 0.0, 0.15);
    const Eigen::MatrixXcd G = referencePropagationMatrix(point, array, Medium());
    const double farthest_s =
        (array.positions.colwise() - point).colwise().norm().maxCoeff() / Medium().soundSpeed();
    array.ringing_s = 0.0;
    // All sound of a step has arrived 0.7 ms after it has begun.
    ASSERT_LT(farthest_s, 0.0007);
    const Eigen::VectorXcd p_Pa =
        PressureProbe(array, Medium(), schedule).at(point, from(0.0007, 1e4, 0.1));
    for (int k = 0; k < p_Pa.size(); ++k)
    {
        if (k % 20 > 12) continue; // the next step arrives
        Complex steady = 0.0;
        for (Eigen::Index i = 0; i < array.size(); ++i)
            steady += G(0, i) * Complex(drives[static_cast<std::size_t>(k / 20 % 3)][i]);
        EXPECT_EQ(p_Pa[k], steady) << k;
    }
}

// 1/sqrt(1 + (2 pi f tau)^2) of the envelope's swing.
TEST(PressureProbe, ModulationFallsAsOfAResonance)
{
    const Eigen::Vector3d point(0.0, 0.0, 0.2);
    constexpr int kSteps = 200; // of a period
    for (const double f_Hz : {200.0, 500.0, 1000.0})
    {
        DriveSchedule schedule;
        schedule.drives = {drive(1.0f)};
        for (int k = 0; k < kSteps; ++k)
            schedule.steps.push_back(
                {0, 0.5 + 0.4 * std::cos(base::kTwoPi * k / kSteps), 1.0 / (f_Hz * kSteps)});
        const PressureProbe probe(one(), Medium(), schedule);
        const Eigen::VectorXd p =
            probe.at(point, from(0.3, 1000.0 * f_Hz > 1e6 ? 1e6 : 1000.0 * f_Hz, 1.0 / f_Hz))
                .cwiseAbs() /
            std::abs(probe.steadyAt(point)[0]);
        const double swing = 0.5 * (p.maxCoeff() - p.minCoeff());
        const double formula = 0.4 / std::hypot(1.0, base::kTwoPi * f_Hz * kTau_s);
        EXPECT_NEAR(swing, formula, 0.005 * formula) << f_Hz;
    }
}

TEST(PressureProbe, WhatCannotBeProbedIsRefused)
{
    const auto message = [](const auto& act) -> std::string
    {
        try
        {
            act();
        }
        catch (const base::InputError& error)
        {
            return error.what();
        }
        return "no error";
    };
    const PressureProbe probe(one(), Medium(), inTurn({drive(1.0f)}, 1.0));
    const auto at = [&](double begin_s, double rate_Hz, double duration_s) {
        return message([&] { probe.at({0, 0, 1}, from(begin_s, rate_Hz, duration_s)); });
    };
    EXPECT_EQ(at(0.0, 0.0, 1.0), "probe: rate_Hz is 0; it must be within 1 .. 1e+06");
    EXPECT_EQ(at(NAN, 1e3, 1.0), "probe: begin_s is nan; it must be within -3600 .. 3600");
    EXPECT_EQ(at(0.0, 1e3, 0.0), "probe: duration_s is 0; it must be above 0");
    EXPECT_EQ(at(0.0, 1e6, 3600.0), "probe: samples is 3.6e+09; it must be within 0 .. 1e+08");
    EXPECT_EQ(message(
                  [&] {
                      probe.at({0, NAN, 1}, {});
                  }),
              "probe: a coordinate of the point is not finite");
    const auto made = [&](DriveSchedule schedule)
    { return message([&] { PressureProbe(one(), Medium(), std::move(schedule)); }); };
    EXPECT_EQ(
        made({}),
        "probe: schedule: there are no drives or no steps; there must be at least one of each");
    EXPECT_EQ(made(inTurn({Eigen::VectorXcf::Ones(2)}, 1.0)),
              "probe: the schedule's drives are for 2 transducers, the array has 1");
    EXPECT_EQ(made(inTurn({drive(NAN)}, 1.0)),
              "probe: schedule: an activation of drive 0 is not finite");
    EXPECT_EQ(made(inTurn({drive(1.0f)}, 0.0)),
              "probe: schedule: step 0 lasts 0 s; it must be above 0");
}

TEST(PressureProbe, RadiationPressureIsThatOfTheField)
{
    const Eigen::VectorXcd p_Pa = Eigen::Vector2cd(Complex(300.0, 400.0), 0.0);
    const Eigen::VectorXd radiation_Pa = radiationOf(p_Pa, Medium());
    EXPECT_DOUBLE_EQ(radiation_Pa[0], radiationPressure(500.0, Medium()));
    EXPECT_EQ(radiation_Pa[1], 0.0);
}

} // namespace
} // namespace midair::haptics
