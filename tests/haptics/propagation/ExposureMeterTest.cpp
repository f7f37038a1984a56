#include "haptics/propagation/Exposure.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

Eigen::VectorXd levels(double a_dB, double b_dB)
{
    return Eigen::Vector2d(meanSquareOf_Pa2(a_dB), meanSquareOf_Pa2(b_dB));
}

const Eigen::Matrix3Xd kPlaces =
    (Eigen::Matrix3Xd(3, 2) << 0.1, 0.4, 0.2, 0.5, 0.3, 0.6).finished();

} // namespace

TEST(ExposureMeter, AveragesEnergyOverTime)
{
    ExposureMeter meter;
    EXPECT_EQ(meter.read(5.0).places, 0);
    EXPECT_EQ(meter.read(5.0).level_dB, 0.0);
    // 100 s at 110 dB, then 900 s of silence: 10 dB less.
    meter.play(50.0, kPlaces, levels(110.0, 90.0));
    EXPECT_NEAR(meter.read(100.0).eq_dB, 110.0, 1e-6);
    EXPECT_NEAR(meter.read(100.0).level_dB, 110.0, 1e-6);
    meter.play(150.0, kPlaces, Eigen::Vector2d::Zero());
    const ExposureFigures end = meter.read(1050.0);
    EXPECT_EQ(end.places, 2);
    EXPECT_NEAR(end.time_s, 1000.0, 1e-9);
    EXPECT_NEAR(end.eq_dB, 100.0, 1e-6);
    EXPECT_EQ(end.level_dB, 0.0);
    EXPECT_NEAR(end.max_dB, 110.0, 1e-6);
    EXPECT_EQ(Eigen::Vector3d(end.x_m, end.y_m, end.z_m), kPlaces.col(0));
    EXPECT_NEAR(meter.read(1050.0).eq_dB, end.eq_dB, 1e-12) << "reading changes nothing";
}

// The same energy over 8 h: an hour has an eighth of it, and silence behind it changes nothing.
TEST(ExposureMeter, ADayHasTheEnergyOfWhatWasPlayed)
{
    ExposureMeter meter;
    constexpr double kHour_s = 3600.0;
    meter.play(0.0, kPlaces, levels(100.0, 80.0));
    EXPECT_EQ(meter.read(0.0).day_dB, 0.0);
    EXPECT_NEAR(meter.read(8.0 * kHour_s).day_dB, 100.0, 1e-6);
    EXPECT_NEAR(meter.read(16.0 * kHour_s).day_dB, 100.0 + 10.0 * std::log10(2.0), 1e-6);
    meter.play(kHour_s, kPlaces, Eigen::Vector2d::Zero());
    EXPECT_NEAR(meter.read(kHour_s).day_dB, 100.0 - 10.0 * std::log10(8.0), 1e-6);
    EXPECT_NEAR(meter.read(5.0 * kHour_s).day_dB, 100.0 - 10.0 * std::log10(8.0), 1e-6);
}

TEST(ExposureMeter, TheLoudestSecondIsKeptWithItsPlace)
{
    ExposureMeter meter;
    meter.play(0.0, kPlaces, levels(100.0, 80.0));
    meter.play(10.0, kPlaces, levels(80.0, 120.0));
    meter.play(11.0, kPlaces, levels(80.0, 80.0));
    const ExposureFigures figures = meter.read(100.0);
    EXPECT_NEAR(figures.max_dB, 120.0, 0.01);
    EXPECT_EQ(Eigen::Vector3d(figures.x_m, figures.y_m, figures.z_m), kPlaces.col(1));
    // L_eq is of the place where it is highest: 120 dB for 1 s of 100 against 100 dB for 10 s.
    EXPECT_NEAR(figures.eq_dB, 120.0 - 20.0 + 10.0 * std::log10(1.0 + 99.0 * 1e-4), 0.01);
}

TEST(ExposureMeter, BeforeTheFirstSecondIsOverItsMeanIsTheHighest)
{
    ExposureMeter meter;
    meter.play(0.0, kPlaces, levels(60.0, 110.0));
    const ExposureFigures figures = meter.read(0.35);
    EXPECT_NEAR(figures.max_dB, 110.0, 1e-6);
    EXPECT_NEAR(figures.max_dB, figures.eq_dB, 1e-12);
    EXPECT_EQ(Eigen::Vector3d(figures.x_m, figures.y_m, figures.z_m), kPlaces.col(1));
}

TEST(ExposureMeter, AShorterSoundCountsWithTheSilenceOfItsSecond)
{
    ExposureMeter meter;
    meter.play(0.0, kPlaces, levels(60.0, 60.0));
    meter.play(3.0, kPlaces, levels(120.0, 60.0));
    meter.play(3.2, kPlaces, levels(60.0, 60.0));
    EXPECT_NEAR(meter.read(9.0).max_dB, 120.0 + 10.0 * std::log10(0.2), 0.01);
}

TEST(ExposureMeter, WhatIsNoNumberIsLoud)
{
    ExposureMeter meter;
    meter.play(0.0, kPlaces, Eigen::Vector2d(std::nan(""), 1.0));
    EXPECT_TRUE(std::isinf(meter.read(2.0).level_dB));
}

TEST(ExposureMeter, EachNamedPlaceHasFiguresOfItsOwn)
{
    ExposureMeter meter;
    EXPECT_TRUE(meter.readEach(0.0).empty());
    Eigen::Matrix3Xd places(3, 3);
    places << 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.5;
    const double loud_Pa2 = meanSquareOf_Pa2(140.0);
    const double quiet_Pa2 = meanSquareOf_Pa2(100.0);
    meter.play(10.0, places, Eigen::Vector3d(loud_Pa2, quiet_Pa2, 0.0), 1);
    meter.play(12.0, places, Eigen::Vector3d(loud_Pa2, 0.0, quiet_Pa2), 1);
    const std::vector<PlaceExposure> each = meter.readEach(14.0);
    ASSERT_EQ(each.size(), 2u) << "the first one is nobody's";
    EXPECT_EQ(each[0].x_m, 1.0);
    EXPECT_EQ(each[0].level_dB, 0.0);
    EXPECT_NEAR(each[0].eq_dB, 100.0 - 10.0 * std::log10(2.0), 1e-6) << "half of the time";
    EXPECT_NEAR(each[0].max_dB, 100.0, 1e-6);
    EXPECT_EQ(each[1].x_m, 2.0);
    EXPECT_NEAR(each[1].level_dB, 100.0, 1e-6);
    EXPECT_NEAR(meter.read(14.0).level_dB, 140.0, 1e-6) << "that of the loudest of all";
}
