#include "haptics/surface/Outline.h"
#include "tests/haptics/surface/SamplerChecks.h"

namespace midair::haptics::test
{

namespace
{

/// A line of 34 mm along x.
TriangleMesh line()
{
    return makeMesh({{0.0, 0.0, 0.1}, {0.034, 0.0, 0.1}}, {{0, 1, 1}});
}

} // namespace

TEST(FlatTriangles, ALineIsSampledInEqualStepsFromEndToEnd)
{
    for (const Sampling sampling : {Sampling::SURFACE, Sampling::EDGES})
    {
        const SurfaceSamples samples = sampleSurface(line(), spaced(kSpacing - 1e-6, sampling));
        ASSERT_EQ(samples.size(), 5);
        for (int i = 0; i < 5; ++i)
            EXPECT_TRUE(holds(samples, {0.0085 * i, 0.0, 0.1})) << i;
        EXPECT_TRUE(samples.normals.isZero(0.0));
    }
    EXPECT_EQ(sampleSurface(line(), spaced(kSpacing, Sampling::VERTICES)).size(), 2);
}

TEST(FlatTriangles, CollinearCornersAreTheLineBetweenTheOuterTwo)
{
    for (const Eigen::Vector3i& order : {Eigen::Vector3i(0, 1, 2), {1, 2, 0}, {2, 0, 1}, {1, 0, 2}})
    {
        const TriangleMesh mesh =
            makeMesh({{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, {0.034, 0.0, 0.0}}, {order});
        const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing - 1e-6));
        ASSERT_EQ(samples.size(), 5) << order.transpose();
        for (int i = 0; i < 5; ++i)
            EXPECT_TRUE(holds(samples, {0.0085 * i, 0.0, 0.0})) << order.transpose();
    }
}

TEST(FlatTriangles, PointsAreSampledWhereTheyAre)
{
    const std::vector<Eigen::Vector3d> places = {
        {0.0, 0.0, 0.0}, {0.02, 0.0, 0.0}, {0.02, 0.004, 0.0}, {0.0, 0.03, 0.01}};
    const TriangleMesh mesh = makeMesh(places, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}});
    for (const Sampling sampling : {Sampling::SURFACE, Sampling::EDGES, Sampling::VERTICES})
    {
        const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing, sampling));
        EXPECT_EQ(samples.size(), 3); // the third is nearer to the second than the spacing
        for (const int i : {0, 1, 3})
            EXPECT_TRUE(holds(samples, places[static_cast<std::size_t>(i)])) << i;
    }
    EXPECT_EQ(sampleSurface(makeMesh({Eigen::Vector3d::Zero()}, {{0, 0, 0}}), {}).size(), 1);
}

TEST(FlatTriangles, APointIsInEachOfSeveralSets)
{
    TriangleMesh mesh =
        makeMesh({{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.05, 0.0}}, {{0, 1, 1}, {2, 2, 2}});
    const auto sets = sampleSurfaceSets(mesh, spaced(kSpacing), 3);
    for (const SurfaceSamples& set : sets)
        EXPECT_TRUE(holds(set, {0.0, 0.05, 0.0}));
    EXPECT_FALSE(holds(sets[1], {0.0, 0.0, 0.0})); // the line is shifted
}

TEST(FlatTriangles, SliversOfASurfaceAreNoLines)
{
    // Two triangles of a square, a sliver on its diagonal and one on a corner.
    const std::vector<Eigen::Vector3d> corners = {
        {0.0, 0.0, 0.0}, {0.02, 0.0, 0.0}, {0.02, 0.02, 0.0}, {0.0, 0.02, 0.0}};
    const TriangleMesh plain = makeMesh(corners, {{0, 1, 2}, {0, 2, 3}});
    const TriangleMesh slivers =
        makeMesh(corners, {{0, 1, 2}, {0, 2, 2}, {0, 2, 3}, {1, 1, 1}, {3, 3, 0}});
    const SurfaceSamples wanted = sampleSurface(plain, spaced(kSpacing));
    EXPECT_EQ(sampleSurface(slivers, spaced(kSpacing)).positions, wanted.positions);
    // The other diagonal is no edge of the surface, so it is a line of its own.
    const TriangleMesh crossed = makeMesh(corners, {{0, 1, 2}, {0, 2, 3}, {1, 3, 3}});
    EXPECT_EQ(featureOutlines(crossed, 0.61, kSpacing).size(), 5U);
    EXPECT_EQ(featureOutlines(plain, 0.61, kSpacing).size(), 4U);
}

TEST(FlatTriangles, ALineIsAnOutlineAndAPointIsOnNone)
{
    TriangleMesh mesh =
        makeMesh({{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.05, 0.0}}, {{0, 1, 1}, {2, 2, 2}});
    int points = -1;
    const auto outlines = featureOutlines(mesh, 0.61, kSpacing, {}, &points);
    ASSERT_EQ(outlines.size(), 1U);
    EXPECT_NEAR(outlines[0].length_m(), 0.1, 1e-12);
    EXPECT_EQ(points, 1);
    mesh.triangles = mesh.triangles.rightCols(1).eval();
    EXPECT_TRUE(featureOutlines(mesh, 0.61, kSpacing, {}, &points).empty());
}

TEST(FlatTriangles, ALineFollowsItsVerticesAndItsPaint)
{
    TriangleMesh mesh = line();
    mesh.intensity.resize(2);
    mesh.intensity << 0.0f, 1.0f;
    SurfaceSamples samples = sampleSurface(mesh, spaced(0.017 - 1e-6));
    ASSERT_EQ(samples.size(), 3);
    mesh.vertices.row(2).setConstant(0.2);
    updateSamples(mesh, samples);
    EXPECT_TRUE(holds(samples, {0.017, 0.0, 0.2}));
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(samples.intensity[i], samples.positions(0, i) / 0.034, 1e-6);
}

} // namespace midair::haptics::test
