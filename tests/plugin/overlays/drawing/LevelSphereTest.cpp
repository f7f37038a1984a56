#include "plugin/overlays/drawing/LevelSphere.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A level that grows with the place along the y axis: 100 dB at -0.5 m, 120 dB at 0.5 m.
Eigen::VectorXf rising()
{
    const Eigen::Matrix3Xd places = LevelSphere::corners(0.5);
    Eigen::VectorXf levels_dB(places.cols());
    for (Eigen::Index l = 0; l < places.cols(); ++l)
        levels_dB[l] = static_cast<float>(110.0 + 20.0 * places(1, l));
    return levels_dB;
}

} // namespace

TEST(LevelSphere, CornersAreRingsOnTheSphere)
{
    const Eigen::Matrix3Xd places = LevelSphere::corners(0.5);
    ASSERT_EQ(places.cols(), 13 * 25);
    for (Eigen::Index l = 0; l < places.cols(); ++l)
        EXPECT_NEAR(places.col(l).norm(), 0.5, 1e-12);
    EXPECT_NEAR(places(1, 0), 0.5, 1e-12) << "the pole";
    EXPECT_LT((places.col(25 * 6) - places.col(25 * 6 + 24)).norm(), 1e-12) << "once around";
}

TEST(LevelSphere, TheGridGoesThroughTheCorners)
{
    const Eigen::VectorXf levels_dB = rising();
    const LevelSphere::Grid grid = LevelSphere::gridOf(levels_dB, 0.5);
    ASSERT_EQ(grid.places.size(), std::size_t(49 * 97));
    EXPECT_EQ(grid.faces.size(), std::size_t(2 * 3 * 48 * 96));
    const Eigen::Matrix3Xd places = LevelSphere::corners(0.5);
    for (int ring = 0; ring < 13; ++ring)
        for (int k = 0; k < 25; ++k)
        {
            const auto at = static_cast<std::size_t>(4 * ring * 97 + 4 * k);
            const int corner = ring * 25 + k;
            EXPECT_EQ(grid.levels_dB[at], levels_dB[corner]);
            EXPECT_NEAR(grid.places[at].y(), places(1, corner), 1e-6);
            EXPECT_NEAR(grid.places[at].x(), places(0, corner), 1e-6);
        }
}

TEST(LevelSphere, NothingIsDrawnBesideWhatIsNotHeard)
{
    Eigen::VectorXf levels_dB = rising();
    levels_dB[6 * 25 + 10] = 0.0F;
    const LevelSphere::Grid grid = LevelSphere::gridOf(levels_dB, 0.5);
    EXPECT_LT(grid.faces.size(), std::size_t(2 * 3 * 48 * 96));
    for (const unsigned int corner : grid.faces)
        EXPECT_GE(grid.levels_dB[corner], 100.0F) << "never between a level and none";
    const LevelSphere::Grid none =
        LevelSphere::gridOf(Eigen::VectorXf::Zero(levels_dB.size()), 0.5);
    EXPECT_TRUE(none.faces.empty());
    EXPECT_TRUE(LevelSphere::contoursOf(none, 5.0F).empty());
}

TEST(LevelSphere, LinesAreWhereTheLevelIs)
{
    const auto contours = LevelSphere::contoursOf(LevelSphere::gridOf(rising(), 0.5), 5.0F);
    // At the ends a line is a point.
    ASSERT_GE(contours.size(), 3U);
    int found = 0;
    for (const LevelSphere::Contour& contour : contours)
    {
        EXPECT_GE(contour.level_dB, 100.0F);
        EXPECT_LE(contour.level_dB, 120.0F);
        if (contour.level_dB != 105.0F && contour.level_dB != 115.0F) continue;
        ++found;
        const float y = (contour.level_dB - 110.0F) / 20.0F;
        EXPECT_GE(contour.pieces.size(), 96U);
        for (const auto& [from, to] : contour.pieces)
        {
            EXPECT_NEAR(from.y(), y, 0.01F);
            EXPECT_NEAR(to.y(), y, 0.01F);
            EXPECT_LT((from - to).length(), 0.06F);
        }
        EXPECT_EQ(contour.labels.size(), 4U) << "all around, where it is";
    }
    EXPECT_EQ(found, 2);
}
