#include "engine-bridge/calibration/PointPairs.h"

#include "haptics/base/InputError.h"

#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

PointPairs read(const std::string& text)
{
    std::istringstream in(text);
    return readPointPairs(in, "pairs.csv");
}

std::string readError(const std::string& text)
{
    try
    {
        read(text);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

TEST(PointPairs, ReadsCommasBlanksHeadingsAndComments)
{
    const PointPairs pairs = read("wx, wy, wz, ax, ay, az\n"
                                  "# probe at the upper left\n"
                                  "1,2,3,4,5,6\r\n"
                                  "\n"
                                  "-1e-3 +2.5 3;4\t5 , 6\n");
    ASSERT_EQ(pairs.size(), 2);
    EXPECT_EQ(pairs.world.col(0), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(pairs.array.col(0), Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(pairs.world.col(1), Eigen::Vector3d(-1e-3, 2.5, 3));
    EXPECT_EQ(read("").size(), 0);
}

TEST(PointPairs, ErrorsNameTheLine)
{
    EXPECT_EQ(readError("1,2,3,4,5,6\n1,2,3,4,5\n"),
              "pairs.csv, line 2: 5 columns; a point pair has six: world x, y, z, array x, y, z");
    EXPECT_EQ(readError("1,2,3,4,5,6\n1,2,three,4,5,6\n"),
              "pairs.csv, line 2: \"three\" in column 3 is not a finite number");
    EXPECT_EQ(readError("1,2,3,4,5,nan\n"),
              "pairs.csv, line 1: \"nan\" in column 6 is not a finite number");
    EXPECT_EQ(readError("1,2,3,4,5,1e999\n"),
              "pairs.csv, line 1: \"1e999\" in column 6 is not a finite number");
    EXPECT_EQ(readError("a,b,c,d,e,f\nalso,no,numbers,in,this,one\n"),
              "pairs.csv, line 2: \"also\" in column 1 is not a finite number");
}

TEST(PointPairs, ThereAreAtMostTenThousand)
{
    std::string text;
    for (int i = 0; i <= 10000; ++i)
        text += "1 2 3 4 5 6\n";
    EXPECT_EQ(readError(text),
              "pairs.csv, line 10001: more than 10000 point pairs, which are the most possible");
}

TEST(PointPairs, Units)
{
    EXPECT_EQ(unitInMetres("mm"), 1e-3);
    EXPECT_EQ(unitInMetres("inches"), 0.0254);
    EXPECT_EQ(unitInMetres("0.5"), 0.5);
    EXPECT_EQ(unitName(0.00101), "millimetres");
    EXPECT_EQ(unitName(0.5), "");
    try
    {
        unitInMetres("-1");
        FAIL();
    }
    catch (const base::InputError& error)
    {
        EXPECT_STREQ(
            error.what(),
            "unit \"-1\" is not known; give m, cm, mm, um, in, ft, or the metres a unit has");
    }
}

} // namespace

} // namespace midair::bridge
