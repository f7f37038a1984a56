
#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <random>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using Eigen::Vector3d;

namespace
{

haptics::TriangleMesh box(const Vector3d& size, const Eigen::Isometry3d& pose)
{
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, 8);
    for (int i = 0; i < 8; ++i)
        mesh.vertices.col(i) = pose * Vector3d(0.5 * (i & 1 ? size.x() : -size.x()),
                                               0.5 * (i & 2 ? size.y() : -size.y()),
                                               0.5 * (i & 4 ? size.z() : -size.z()));
    mesh.triangles.resize(3, 12);
    mesh.triangles << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1, //
        2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,               //
        3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
    return mesh;
}

Eigen::Isometry3d somewhere()
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        Eigen::AngleAxisd(1.1, Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    pose.translation() = Vector3d(0.1, -0.2, 0.3);
    return pose;
}

double gap(const Vector3d& point, const std::vector<Capsule>& capsules)
{
    double nearest = 1e9;
    for (const Capsule& c : capsules)
        nearest = std::min(nearest, pointSegmentDistance(point, c.a, c.b) - c.radius_m);
    return nearest;
}

} // namespace

TEST(ObstacleFit, ARodIsOneCapsule)
{
    const auto capsules = capsulesOf(box({0.012, 0.2, 0.01}, somewhere()));
    ASSERT_EQ(capsules.size(), 1u);
    const Capsule& rod = capsules[0];
    EXPECT_NEAR(rod.radius_m, 0.25 * (0.012 + 0.01), 1e-9);
    EXPECT_NEAR((rod.b - rod.a).norm() + 2.0 * rod.radius_m, 0.2, 1e-9) << "as long as the rod";
    EXPECT_LT((0.5 * (rod.a + rod.b) - somewhere().translation()).norm(), 1e-9);
    const Vector3d along = somewhere().linear() * Vector3d::UnitY();
    EXPECT_NEAR(std::abs((rod.b - rod.a).normalized().dot(along)), 1.0, 1e-9);
}

TEST(ObstacleFit, ASphereIsABall)
{
    const auto capsules = capsulesOf(*sphere(0.03, 20));
    ASSERT_EQ(capsules.size(), 1u);
    EXPECT_NEAR(capsules[0].radius_m, 0.03, 0.001);
    EXPECT_LT((capsules[0].a - capsules[0].b).norm(), 0.002);
}

TEST(ObstacleFit, APlateIsFilledAndNothingStandsOut)
{
    const Vector3d size(0.1, 0.16, 0.01);
    const auto capsules = capsulesOf(box(size, somewhere()), 0.01);
    EXPECT_EQ(capsules.size(), 10u);
    EXPECT_EQ(capsulesOf(box(size, somewhere()), 0.02).size(), 5u);
    EXPECT_EQ(capsulesOf(box(size, somewhere()), 0.01, 3).size(), 3u);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(-0.5, 0.5);
    int covered = 0;
    for (int i = 0; i < 2000; ++i)
    {
        const Vector3d inside(size.x() * unit(random), size.y() * unit(random), 0.0);
        if (gap(somewhere() * inside, capsules) <= 1e-9) ++covered;
    }
    EXPECT_GT(covered, 1900) << "of 2000 spots in its middle plane; corners are rounded";
    for (int i = 0; i < 2000; ++i)
    {
        Vector3d outside(2.0 * unit(random), 2.0 * unit(random), 2.0 * unit(random));
        outside = outside.cwiseProduct(size);
        if ((outside.cwiseAbs() - 0.5 * size).maxCoeff() < 0.001) continue;
        EXPECT_GT(gap(somewhere() * outside, capsules), 0.0);
    }
}

TEST(ObstacleFit, ATriangularPlatesStripsAreAsLongAsItIsThere)
{
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, 3);
    mesh.vertices << 0.0, 0.2, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0;
    mesh.triangles.resize(3, 1);
    mesh.triangles << 0, 1, 2;
    const auto capsules = capsulesOf(mesh, 0.0125);
    ASSERT_EQ(capsules.size(), 8u);
    EXPECT_LT(gap({0.05, 0.04, 0.0}, capsules), 1e-9) << "inside the triangle";
    EXPECT_GT(gap({0.15, 0.08, 0.0}, capsules), 0.02) << "the other half of its box";
}

TEST(ObstacleFit, APlatesShadowIsThatOfARectangle)
{
    // Half way between source and point: the weight by Babinet's principle for the plate's own
    // rectangle, written apart.
    const double wavelength = 8.58e-3;
    const Vector3d size(0.12, 0.08, 0.005);
    const Vector3d source(0.0, 0.0, -0.15);
    const double scale = std::sqrt(2.0 * 0.3 / (wavelength * 0.15 * 0.15));
    for (const double shift : {0.0, 0.02, 0.035, 0.05, 0.07, 0.1})
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation().y() = shift;
        haptics::TransducerArray one;
        double weight = 1.0;
        for (const Capsule& capsule : capsulesOf(box(size, pose)))
            weight *= shadowWeight(source, -source, capsule, wavelength);
        const double wanted = pastRectangle(
            (shift - 0.04) * scale, (shift + 0.04) * scale, -0.06 * scale, 0.06 * scale);
        EXPECT_NEAR(weight, wanted, 0.15) << shift; // what the strips' rounded sides let through
    }
}

TEST(ObstacleFit, NoTrianglesNoObstacle)
{
    EXPECT_TRUE(capsulesOf({}).empty());
}
