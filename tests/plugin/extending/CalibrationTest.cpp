#include <osgMidair/Calibration>

#include <osg/Matrixd>

#include <fstream>
#include <limits>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

const osg::Matrixd kTruth =
    osg::Matrixd::rotate(0.7, osg::Vec3d(1, 2, -1)) * osg::Matrixd::translate(0.4, -1.2, 0.3);

std::vector<osg::Vec3d> spots(int count)
{
    std::vector<osg::Vec3d> all;
    for (int k = 0; k < count; ++k)
        all.emplace_back(
            0.1 * std::sin(1.0 * k), 0.1 * std::cos(2.3 * k), 0.1 * std::sin(4.1 * k + 1.0));
    return all;
}

std::vector<osg::Vec3d> inArray(const std::vector<osg::Vec3d>& world)
{
    std::vector<osg::Vec3d> all;
    for (const osg::Vec3d& spot : world)
        all.push_back(spot * kTruth);
    return all;
}

} // namespace

TEST(Calibration, FindsTheMatrixThatSetCalibrationTakes)
{
    const auto world = spots(14);
    auto array = inArray(world);
    array[5].z() += 0.06;
    const CalibrationReport report = calibrate(world, array);
    ASSERT_TRUE(report.usable) << report.text;
    for (int k = 0; k < 16; ++k)
        EXPECT_NEAR(report.worldToArray.ptr()[k], kTruth.ptr()[k], 1e-9) << k;
    ASSERT_EQ(report.outlier.size(), 14u);
    EXPECT_TRUE(report.outlier[5]);
    EXPECT_NEAR(report.residuals_m[5], 0.06, 1e-9);
    EXPECT_TRUE(report.has(CalibrationWarning::OUTLIERS));
    EXPECT_NE(report.text.find("calibrated from 13 of 14 point pairs"), std::string::npos);
}

TEST(Calibration, WhatCannotBeUsedSaysWhy)
{
    const auto world = spots(14);
    const CalibrationReport few = calibrate(spots(2), inArray(spots(2)));
    EXPECT_FALSE(few.usable);
    EXPECT_TRUE(few.has(CalibrationWarning::TOO_FEW_POINTS)) << few.text;
    EXPECT_TRUE(few.worldToArray.isIdentity());

    const CalibrationReport uneven = calibrate(world, spots(3));
    EXPECT_TRUE(uneven.has(CalibrationWarning::WRONG_INPUT));
    EXPECT_EQ(
        uneven.text,
        "there are 14 points in the world and 3 in the array; there must be as many of each\n");

    auto broken = world;
    broken[2].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(calibrate(broken, world).has(CalibrationWarning::WRONG_INPUT));
    CalibrationOptions options;
    options.trials = 0;
    EXPECT_TRUE(calibrate(world, world, options).has(CalibrationWarning::WRONG_INPUT));
}

TEST(Calibration, PairsAndUnitsAreReadAsMidairCalibrateDoes)
{
    const std::string file = testing::TempDir() + "midair-pairs-from-code.csv";
    std::ofstream(file) << "world x,world y,world z,array x,array y,array z\n"
                        << "# a comment\n1,2,3,4,5,6\n7 8 9 10 11 12\n";
    PointPairs pairs;
    std::string error;
    ASSERT_TRUE(readPointPairs(file, pairs, error)) << error;
    ASSERT_EQ(pairs.world.size(), 2u);
    ASSERT_EQ(pairs.array.size(), 2u);
    EXPECT_EQ(pairs.world[1], osg::Vec3d(7, 8, 9));
    EXPECT_EQ(pairs.array[0], osg::Vec3d(4, 5, 6));

    std::ofstream(file) << "1 2 3 4 5 6\n1 2 3\n";
    EXPECT_FALSE(readPointPairs(file, pairs, error));
    EXPECT_EQ(error,
              file + ", line 2: 3 columns; a point pair has six: world x, y, z, array x, y, z");
    EXPECT_EQ(pairs.world.size(), 2u); // as they were
    EXPECT_FALSE(readPointPairs("/nowhere/pairs.csv", pairs, error));
    EXPECT_EQ(error,
              "point pairs \"/nowhere/pairs.csv\": can't be read: No such file or directory; give "
              "a file of point pairs, or - for stdin");

    error.clear();
    EXPECT_EQ(unitInMetres("mm", error), 1e-3);
    EXPECT_EQ(unitInMetres("0.5", error), 0.5);
    EXPECT_EQ(error, "");
    EXPECT_EQ(unitInMetres("cubit", error), 0.0);
    EXPECT_EQ(error,
              "unit \"cubit\" is not known; give m, cm, mm, um, in, ft, or the metres a unit has");
}
