#include "haptics/scattering/RoundBody.h"

#include "haptics/base/InputError.h"
#include "haptics/scattering/ClosedBody.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using haptics::RoundCone;

namespace
{

const Eigen::Vector3d kBallCentre = Eigen::Vector3d::Zero();
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Throws unless it is closed, wound alike, and without faces on each other.
haptics::ClosedBody closed(const haptics::TriangleMesh& mesh)
{
    return haptics::ClosedBody::from(mesh, kNoLimit, 100000);
}

double volumeInside(const haptics::ClosedBody& body)
{
    double volume = 0.0;
    for (Eigen::Index i = 0; i < body.size(); ++i)
        volume += body.areas[i] * body.normals.col(i).dot(body.centres.col(i)) / 3.0;
    return volume;
}

double smallestAngle_deg(const haptics::ClosedBody& body)
{
    double least = 180.0;
    for (Eigen::Index i = 0; i < body.size(); ++i)
        for (int k = 0; k < 3; ++k)
        {
            const Eigen::Vector3d at = body.corners.col(3 * i + k);
            const Eigen::Vector3d one = body.corners.col(3 * i + (k + 1) % 3) - at,
                                  other = body.corners.col(3 * i + (k + 2) % 3) - at;
            least =
                std::min(least, std::atan2(one.cross(other).norm(), one.dot(other)) * 180.0 / M_PI);
        }
    return least;
}

/// Three fingers that part at a narrow angle, where parts of a coarse mesh touch.
std::vector<RoundCone> fingers()
{
    std::vector<RoundCone> cones;
    for (const double side : {-1.0, 0.0, 1.0})
        cones.push_back({{0.0, 0.0, 0.0}, {0.018 * side, 0.004 * side, 0.06}, 0.01, 0.006});
    return cones;
}

} // namespace

TEST(RoundBody, DistanceIsThatOfBallsAndOfTheSidesBetween)
{
    const RoundCone ball{{0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}, 0.02, 0.02};
    EXPECT_NEAR(haptics::distanceTo({ball}, {0.1, 0.05, 0.0}), 0.03, 1e-12);
    EXPECT_NEAR(haptics::distanceTo({ball}, {0.1, 0.0, 0.005}), -0.015, 1e-12);
    const RoundCone cone{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.1}, 0.03, 0.01};
    EXPECT_NEAR(haptics::distanceTo({cone}, {0.0, 0.0, -0.05}), 0.02, 1e-12);
    EXPECT_NEAR(haptics::distanceTo({cone}, {0.0, 0.0, 0.2}), 0.09, 1e-12);
    // The smallest distance to the balls that roll from one end to the other, apart from the
    // product.
    for (const Eigen::Vector3d& place : {Eigen::Vector3d(0.05, 0.0, 0.03),
                                         Eigen::Vector3d(0.03, 0.03, 0.09),
                                         Eigen::Vector3d(0.04, -0.01, 0.0)})
    {
        double least = kNoLimit;
        for (int k = 0; k <= 100000; ++k)
            least = std::min(
                least, (place - Eigen::Vector3d(0.0, 0.0, 1e-6 * k)).norm() - 0.03 + 2e-7 * k);
        EXPECT_NEAR(haptics::distanceTo({cone}, place), least, 1e-9);
        EXPECT_EQ(haptics::distanceTo({ball, cone}, place),
                  std::min(haptics::distanceTo({ball}, place), haptics::distanceTo({cone}, place)));
    }
    const RoundCone within{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.01}, 0.03, 0.005};
    EXPECT_NEAR(haptics::distanceTo({within}, {0.0, 0.0, 0.05}), 0.02, 1e-12);
}

// At all sizes of cells, each of which cuts differently; the sharpest corners are between fingers.
TEST(RoundBody, IsClosedWithoutSlivers)
{
    for (double cell_m = 8e-3; cell_m > 1.5e-3; cell_m *= 0.93)
    {
        const haptics::ClosedBody body = closed(haptics::roundBody(fingers(), cell_m));
        EXPECT_GT(smallestAngle_deg(body), 4.0) << cell_m;
        for (Eigen::Index i = 0; i < body.size(); ++i)
        {
            const Eigen::Vector3d centre = body.centres.col(i);
            ASSERT_LT(std::abs(haptics::distanceTo(fingers(), centre)), 0.3 * cell_m) << cell_m;
        }
    }
}

TEST(RoundBody, FlatTrianglesAreOnTheSurfaceInTheMean)
{
    const double radius_m = 0.01;
    for (const double cell_m : {5e-3, 3e-3, 1.5e-3})
    {
        const haptics::ClosedBody body =
            closed(haptics::roundBody({{kBallCentre, kBallCentre, radius_m, radius_m}}, cell_m));
        const double volume = 4.0 / 3.0 * M_PI * std::pow(radius_m, 3);
        EXPECT_NEAR(volumeInside(body), volume, 2e-3 * volume) << cell_m;
        EXPECT_GT(smallestAngle_deg(body), 20.0) << cell_m;
        EXPECT_TRUE(body.isInside(Eigen::Vector3d::Zero()));
        EXPECT_FALSE(body.isInside({0.0, 0.0, 1.2 * radius_m}));
    }
}

TEST(RoundBody, IsAsFineAsAllowed)
{
    for (const Eigen::Index most : {1000, 4000})
    {
        const haptics::TriangleMesh mesh = haptics::finestRoundBody(fingers(), most);
        EXPECT_LE(mesh.triangles.cols(), most);
        EXPECT_GE(mesh.triangles.cols(), 0.9 * static_cast<double>(most));
        closed(mesh);
    }
}

TEST(RoundBody, IsRefusedByName)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(haptics::roundBody({}, 1e-3), base::InputError);
    EXPECT_THROW(haptics::roundBody({{kBallCentre, kBallCentre, 0.0, 0.01}}, 1e-3),
                 base::InputError);
    EXPECT_THROW(haptics::roundBody({{{nan, 0.0, 0.0}, kBallCentre, 0.01, 0.01}}, 1e-3),
                 base::InputError);
    EXPECT_THROW(haptics::roundBody({{kBallCentre, kBallCentre, 0.01, kNoLimit}}, 1e-3),
                 base::InputError);
    EXPECT_THROW(haptics::roundBody({{kBallCentre, {1e3, 0.0, 0.0}, 0.01, 0.01}}, 1e-3),
                 base::InputError);
    EXPECT_THROW(haptics::finestRoundBody({}, 1000), base::InputError);
}
