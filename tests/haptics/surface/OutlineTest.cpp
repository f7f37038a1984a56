#include "haptics/surface/Outline.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

std::string messageOf(const Outline& outline, double spacing_m)
{
    try
    {
        outline.points(spacing_m);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

TEST(Outline, StepsEvenlyAlongALineWithBothEnds)
{
    const Outline line = Outline::line({-0.05, 0, 0}, {0.05, 0, 0});
    const Eigen::Matrix3Xd points = line.points(0.003);
    ASSERT_EQ(points.cols(), 35); // 100 mm in 34 steps of 2.94 mm
    EXPECT_EQ(points.col(0), Eigen::Vector3d(-0.05, 0, 0));
    // Rounding of 34 steps.
    EXPECT_NEAR((points.col(34) - Eigen::Vector3d(0.05, 0, 0)).norm(), 0.0, 1e-15);
    for (int k = 0; k < 34; ++k)
        EXPECT_NEAR((points.col(k + 1) - points.col(k)).norm(), 0.1 / 34, 1e-15);
}

TEST(Outline, AWholeNumberOfSpacingsIsThatManySteps)
{
    EXPECT_EQ(Outline::line({0, 0, 0}, {0.1, 0, 0}).points(0.01).cols(), 11);
}

TEST(Outline, ClosedOnesMeetTheirFirstPointAtTheSameStep)
{
    Outline square;
    square.closed = true;
    square.vertices.resize(3, 4);
    square.vertices << 0, 0.02, 0.02, 0, 0, 0, 0, 0, 0, 0, 0.02, 0.02;
    const Eigen::Matrix3Xd points = square.points(0.005);
    ASSERT_EQ(points.cols(), 16);
    for (int k = 0; k < 16; ++k)
        EXPECT_NEAR((points.col((k + 1) % 16) - points.col(k)).norm(), 0.005, 1e-15);
}

TEST(Outline, CirclesLieAcrossTheirAxis)
{
    const Eigen::Vector3d centre(0.01, -0.02, 0.03), axis(0.0, 1.0, 1.0);
    const Outline circle = Outline::circle(centre, 0.034, axis, 720);
    // The polygon is shorter by (pi/720)^2 / 6.
    EXPECT_NEAR(circle.length_m(), M_PI * 0.034, 1e-6);
    const Eigen::Matrix3Xd points = circle.points(0.002);
    for (const auto& r : points.colwise())
    {
        EXPECT_NEAR((r - centre).dot(axis), 0.0, 1e-15);
        EXPECT_NEAR((r - centre).norm(), 0.017, 2e-7); // the polygon's sagitta
    }
}

TEST(Outline, SaysWhatIsWrong)
{
    Outline outline;
    EXPECT_EQ(messageOf(outline, 0.01), "outline: 0 vertices; an open one needs at least 2");
    outline.closed = true;
    outline.vertices.setZero(3, 2);
    EXPECT_EQ(messageOf(outline, 0.01), "outline: 2 vertices; a closed one needs at least 3");
    outline.vertices.setZero(3, 3);
    EXPECT_EQ(messageOf(outline, 0.01), "outline: its length is 0; it must be above 0");
    outline.vertices(1, 1) = std::nan("");
    EXPECT_EQ(messageOf(outline, 0.01), "outline: a vertex is not finite");
    const Outline line = Outline::line({0, 0, 0}, {1, 0, 0});
    EXPECT_EQ(messageOf(line, 0.0),
              "outline: points 0 m apart along 1 m; the spacing must be above 1e-05 m");
    EXPECT_EQ(messageOf(line, 1e-7),
              "outline: points 1e-07 m apart along 1 m; the spacing must be above 1e-05 m");
}

TEST(FeatureOutlines, ABoxHasTwelveEdgesADiscItsRim)
{
    double length = 0.0;
    const std::vector<Outline> edges = featureOutlines(test::box({0.04, 0.05, 0.06}), 0.61, 0.0085);
    EXPECT_EQ(edges.size(), 12u);
    for (const Outline& edge : edges)
    {
        EXPECT_FALSE(edge.closed);
        length += edge.length_m();
    }
    EXPECT_NEAR(length, 4 * (0.04 + 0.05 + 0.06), 1e-9);

    const std::vector<Outline> rim = featureOutlines(test::disc(0.03, 60), 0.61, 0.0085);
    ASSERT_EQ(rim.size(), 1u);
    EXPECT_TRUE(rim[0].closed);
    EXPECT_EQ(rim[0].vertices.cols(), 60);
    EXPECT_NEAR(rim[0].length_m(), 60 * 2 * 0.03 * std::sin(M_PI / 60), 1e-9);
    for (const auto& corner : rim[0].vertices.colwise())
        EXPECT_NEAR(corner.norm(), 0.03, 1e-9);
    EXPECT_THROW(featureOutlines(test::sphere(0.03, 3), 0.61, 0.0085), base::InputError);
}

} // namespace
} // namespace midair::haptics
