#include "engine-bridge/scene/Convert.h"

#include <osg/Matrixd>
#include <osg/Quat>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair::bridge;

namespace
{

osg::Matrixd someMatrix()
{
    return osg::Matrixd::scale(2.0, 3.0, 4.0) *
           osg::Matrixd::rotate(0.7, osg::Vec3d(1.0, 2.0, -1.0)) *
           osg::Matrixd::translate(0.1, -0.2, 0.3);
}

} // namespace

TEST(Convert, MapsAPointAsOsgDoes)
{
    const osg::Matrixd m = someMatrix();
    const osg::Vec3d v(0.3, -0.5, 0.9);
    const Eigen::Vector4d mapped = toEigen(m) * toEigen(v).homogeneous();
    // Both are sums of three products in double: rounding only.
    EXPECT_LT((mapped.head<3>() - toEigen(v * m)).norm(), 1e-15);
}

TEST(Convert, BackAndForthIsExact)
{
    const osg::Matrixd m = someMatrix();
    EXPECT_EQ(toOsg(toEigen(m)).compare(m), 0);
    EXPECT_EQ(toOsg(Eigen::Vector3d(1.0, 2.0, 3.0)), osg::Vec3d(1.0, 2.0, 3.0));
}

TEST(Decompose, PoseTimesStretchIsTheMatrix)
{
    PoseAndStretch parts;
    const Eigen::Matrix4d m = toEigen(someMatrix());
    ASSERT_TRUE(decompose(m, parts));
    // A 3 x 3 singular value decomposition is good to some 1e-15 of the largest scale, 4.
    EXPECT_LT((parts.pose.linear() * parts.stretch - m.topLeftCorner<3, 3>()).norm(), 1e-13);
    EXPECT_NEAR(parts.pose.linear().determinant(), 1.0, 1e-13);
    EXPECT_LT((parts.stretch - parts.stretch.transpose()).norm(), 1e-13);
}

TEST(Decompose, TurningLeavesTheStretchAlone)
{
    PoseAndStretch still;
    PoseAndStretch turned;
    const osg::Matrixd turn = osg::Matrixd::rotate(1.1, osg::Vec3d(0.0, 1.0, 1.0));
    ASSERT_TRUE(decompose(toEigen(someMatrix()), still));
    ASSERT_TRUE(decompose(toEigen(someMatrix() * turn), turned));
    EXPECT_TRUE(still.stretch.isApprox(turned.stretch, 1e-12));
}

TEST(Decompose, AMirrorImageGoesIntoTheStretch)
{
    PoseAndStretch parts;
    ASSERT_TRUE(decompose(toEigen(osg::Matrixd::scale(-1.0, 1.0, 1.0)), parts));
    EXPECT_NEAR(parts.pose.linear().determinant(), 1.0, 1e-15);
    EXPECT_LT((parts.pose.linear() * parts.stretch -
               Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal().toDenseMatrix())
                  .norm(),
              1e-15);
}

TEST(Decompose, RefusesWhatCannotBeFelt)
{
    PoseAndStretch parts;
    EXPECT_FALSE(decompose(toEigen(osg::Matrixd::scale(0.0, 0.0, 0.0)), parts));
    EXPECT_FALSE(decompose(toEigen(osg::Matrixd::scale(1.0, 1.0, 0.0)), parts)) << "flattened";
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(decompose(m, parts)) << "not a number";
    m = Eigen::Matrix4d::Identity();
    m(3, 2) = -1.0;
    EXPECT_FALSE(decompose(m, parts)) << "perspective";
}
