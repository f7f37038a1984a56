#include "haptics/tuning/TouchedPlate.h"

#include "haptics/base/InputError.h"

#include <Eigen/Geometry>

#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

const Eigen::Isometry3d kPose =
    Eigen::Translation3d(0.02, -0.05, 0.3) *
    Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, 0.3, -0.4).normalized());

/// The corners of a plate of 0.2 x 0.15 m, and places inside it, each off by \a noise_m (rms).
Eigen::Matrix3Xd touchedPlaces(int inside, double noise_m, unsigned seed = 1)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> in(-0.5, 0.5);
    std::normal_distribution<double> off(0.0, 1.0);
    Eigen::Matrix3Xd places(3, 4 + inside);
    for (int i = 0; i < places.cols(); ++i)
    {
        const double u = i < 4 ? (i & 1) - 0.5 : in(random);
        const double v = i < 4 ? (i >> 1) - 0.5 : in(random);
        places.col(i) = kPose * Eigen::Vector3d(0.2 * u, 0.15 * v, 0.0);
        for (int axis = 0; axis < 3; ++axis)
            places(axis, i) += noise_m * off(random);
    }
    return places;
}

const Eigen::Vector3d kInFront = kPose * Eigen::Vector3d(0.0, 0.0, 0.4);

std::string whyRefused(const Eigen::Matrix3Xd& places)
{
    try
    {
        TouchedPlate::at(places, kInFront);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

TEST(TouchedPlate, IsTheRectangleOfItsCorners)
{
    for (const int inside : {0, 20})
    {
        const TouchedPlate plate = TouchedPlate::at(touchedPlaces(inside, 0.0), kInFront);
        EXPECT_LT((plate.reflector.position - kPose.translation()).norm(), 1e-4);
        EXPECT_GT(plate.reflector.normal.dot(kPose.linear().col(2)), 1.0 - 1e-9);
        EXPECT_NEAR(plate.reflector.size_m.maxCoeff(), 0.2, 2e-4);
        EXPECT_NEAR(plate.reflector.size_m.minCoeff(), 0.15, 2e-4);
        const bool isFirstLong = plate.reflector.size_m.x() > plate.reflector.size_m.y();
        const Eigen::Vector3d side = isFirstLong ? plate.reflector.along : plate.reflector.across();
        EXPECT_GT(std::abs(side.dot(kPose.linear().col(0))), 1.0 - 1e-5);
        EXPECT_LT(plate.off_m, 1e-9);
        std::string why;
        EXPECT_TRUE(areValid({plate.reflector}, &why)) << why;
    }
    const TouchedPlate behind =
        TouchedPlate::at(touchedPlaces(0, 0.0), kPose * Eigen::Vector3d(0.0, 0.0, -0.4));
    EXPECT_LT(behind.reflector.normal.dot(kPose.linear().col(2)), -1.0 + 1e-9);
}

// Half a millimetre of each touch: near enough for a fit, which looks within 6 mm and 2 degrees,
// and its error is about what it says.
TEST(TouchedPlate, SaysHowWellItIsKnown)
{
    double off2 = 0.0, said2 = 0.0;
    constexpr int kSeeds = 50;
    for (unsigned seed = 0; seed < kSeeds; ++seed)
    {
        const TouchedPlate plate = TouchedPlate::at(touchedPlaces(8, 5e-4, seed), kInFront);
        const Eigen::Vector3d normal = kPose.linear().col(2);
        EXPECT_GT(plate.reflector.normal.dot(normal), std::cos(0.01));
        EXPECT_LT((plate.reflector.position - kPose.translation()).norm(), 2e-3);
        // The plane of least squares is best known at the mean of the places.
        const Eigen::Vector3d mean = touchedPlaces(8, 5e-4, seed).rowwise().mean();
        const double off = normal.dot(mean - kPose.translation());
        off2 += off * off;
        said2 += 1e-6 * plate.reflector.accuracy_mm * plate.reflector.accuracy_mm;
    }
    EXPECT_NEAR(std::sqrt(said2 / off2), 1.0, 0.3);
}

TEST(TouchedPlate, WhatIsNoPlateIsRefusedByName)
{
    EXPECT_EQ(whyRefused(touchedPlaces(0, 0.0).leftCols(3)),
              "3 places were touched; a plate needs its four corners");
    Eigen::Matrix3Xd line(3, 4);
    line << 0.0, 0.1, 0.2, 0.3, 0.0, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
    EXPECT_EQ(whyRefused(line), "the touched places lie on a line, to 1.0 mm");
    Eigen::Matrix3Xd bent = touchedPlaces(8, 0.0);
    bent.col(11) += 0.02 * kPose.linear().col(2);
    EXPECT_NE(whyRefused(bent).find("touched place 12 is 1"), std::string::npos)
        << whyRefused(bent);
    Eigen::Matrix3Xd none = touchedPlaces(0, 0.0);
    none(0, 0) = std::nan("");
    EXPECT_EQ(whyRefused(none), "a touched place isn't finite");
    EXPECT_FALSE(whyRefused(Eigen::Matrix3Xd::Zero(3, 5)).empty());
}
