#include "haptics/points/ControlPoints.h"

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

TEST(FeltPlaces, HaveTheTargetOfTheNearestPoint)
{
    ControlPoints points;
    points.positions.resize(3, 2);
    points.positions << 0.0, 0.01, 0.0, 0.0, 0.0, 0.0;
    points.targets = Eigen::Vector2d(1.0, 0.5);
    points.absolute = true;
    Eigen::Matrix3Xd samples(3, 5);
    samples.setZero();
    samples.row(0) << -0.006, 0.004, 0.006, 0.0149, 0.0151;
    const ControlPoints places = feltPlaces(samples, points, 0.005);
    ASSERT_EQ(places.size(), 3);
    EXPECT_EQ(places.positions.row(0), Eigen::RowVector3d(0.004, 0.006, 0.0149));
    EXPECT_EQ(places.targets, Eigen::Vector3d(1.0, 0.5, 0.5));
    EXPECT_TRUE(places.absolute);
    EXPECT_EQ(places.normals.cols(), 3);
    EXPECT_EQ(feltPlaces(samples, {}, 0.005).size(), 0);
}

TEST(FeltPlaces, AStopIsThrown)
{
    base::StopSource source;
    source.request();
    ControlPoints points;
    points.positions = Eigen::Matrix3Xd::Zero(3, 1);
    points.targets = Eigen::VectorXd::Ones(1);
    EXPECT_THROW(feltPlaces(Eigen::Matrix3Xd::Zero(3, 100000), points, 1.0, source.token()),
                 base::Stopped);
}

} // namespace
} // namespace midair::haptics
