// Where a pattern is, in front of an array or within it.
#include "samples/tools/sense/SensePlace.h"

#include <gtest/gtest.h>

using namespace midair::samples;

TEST(SensePlaces, InFrontOfAFlatArray)
{
    Eigen::Matrix3Xd positions(3, 4);
    positions << -0.1, 0.1, -0.1, 0.1, -0.1, -0.1, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0;
    Eigen::Matrix3Xd normals = Eigen::Matrix3Xd::Zero(3, 4);
    normals.row(2).setConstant(5.0); // of any length
    Eigen::Matrix4d expected = Eigen::Matrix4d::Identity();
    expected(2, 3) = 0.2;
    EXPECT_TRUE(patternPlace(positions, normals).isApprox(expected));
    // One that looks down turns it over.
    normals.row(2).setConstant(-1.0);
    const Eigen::Matrix4d down = patternPlace(positions, normals);
    EXPECT_NEAR(down(2, 2), -1.0, 1e-12);
    EXPECT_NEAR(down(2, 3), -0.2, 1e-12);
    const Eigen::Matrix3d turn = down.topLeftCorner<3, 3>();
    EXPECT_TRUE((turn * turn.transpose()).isIdentity(1e-12));
    EXPECT_TRUE(down.allFinite());
}

TEST(SensePlaces, AtTheOriginWithinAnArray)
{
    Eigen::Matrix3Xd positions(3, 4);
    positions << 0.2, -0.2, 0.0, 0.0, 0.0, 0.0, 0.2, -0.2, 0.0, 0.0, 0.0, 0.0;
    EXPECT_TRUE(patternPlace(positions, -positions).isIdentity());
    EXPECT_TRUE(patternPlace({}, {}).isIdentity());
}
