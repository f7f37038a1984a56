#include "haptics/surface/SurfaceSampler.h"
#include "tests/haptics/surface/SamplerChecks.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{

using namespace test;

TEST(SampleSets, Interleave)
{
    const TriangleMesh mesh = sphere(0.03, 3);
    const SamplerOptions options = spaced(kSpacing);
    constexpr int kSets = 8;
    const std::vector<SurfaceSamples> sets = sampleSurfaceSets(mesh, options, kSets);
    ASSERT_EQ(sets.size(), static_cast<std::size_t>(kSets));
    EXPECT_EQ(sets[0].positions, sampleSurface(mesh, options).positions);
    int least = sets[0].size();
    int most = least;
    Eigen::Matrix3Xd all(3, 0);
    Eigen::Matrix3Xd independent(3, 0);
    for (int k = 0; k < kSets; ++k)
    {
        SCOPED_TRACE(k);
        const SurfaceSamples& set = sets[static_cast<std::size_t>(k)];
        expectPromises(mesh, set, kSpacing, 2e-3);
        least = std::min(least, set.size());
        most = std::max(most, set.size());
        SamplerOptions other = options;
        other.seed = 100 + static_cast<unsigned>(k);
        const SurfaceSamples alone = sampleSurface(mesh, other);
        const Eigen::Index n = all.cols();
        const Eigen::Index m = independent.cols();
        all.conservativeResize(3, n + set.size());
        all.rightCols(set.size()) = set.positions;
        independent.conservativeResize(3, m + alone.size());
        independent.rightCols(alone.size()) = alone.positions;
    }
    EXPECT_LE(most, 1.1 * least);
    // Together they leave smaller gaps than as many sets that know nothing of each other, and lie
    // more evenly.
    EXPECT_LT(largestGap(mesh, all, 5e-4), 0.9 * largestGap(mesh, independent, 5e-4));
    EXPECT_GT(meanNearestDistance(all), 1.15 * meanNearestDistance(independent));
    EXPECT_EQ(sampleSurfaceSets(mesh, options, 3)[2].positions, sets[2].positions);
}

// Where a field was not evened out: none of them is near one of the others.
TEST(SampleSets, SamplesBetweenAreInTheGaps)
{
    const TriangleMesh mesh = sphere(0.03, 3);
    const SamplerOptions options = spaced(kSpacing);
    const Eigen::Matrix3Xd first = sampleSurface(mesh, options).positions;
    const SurfaceSamples between = sampleBetween(mesh, options);
    expectPromises(mesh, between, kSpacing, 2e-3);
    Eigen::VectorXd nearest(between.size());
    for (int i = 0; i < between.size(); ++i)
        nearest[i] = (first.colwise() - between.positions.col(i)).colwise().norm().minCoeff();
    EXPECT_GT(nearest.mean(), 0.55 * kSpacing);
    EXPECT_GT(nearest.minCoeff(), 0.05 * kSpacing);
    const SamplerOptions corners = spaced(kSpacing, Sampling::VERTICES);
    EXPECT_EQ(sampleBetween(mesh, corners).positions, sampleSurface(mesh, corners).positions);
}

TEST(SampleSets, ShiftAlongCurves)
{
    const TriangleMesh mesh = disc(0.05, 720);
    const auto sets = sampleSurfaceSets(mesh, spaced(kSpacing, Sampling::EDGES), 4);
    std::vector<double> angles;
    for (const SurfaceSamples& set : sets)
    {
        EXPECT_EQ(set.size(), sets[0].size());
        EXPECT_GE(smallestDistance(set.positions), kSpacing);
        for (const auto& point : set.positions.colwise())
            angles.push_back(std::atan2(point.y(), point.x()));
    }
    std::sort(angles.begin(), angles.end());
    for (std::size_t i = 1; i < angles.size(); ++i)
    {
        // Quarters of a step; the polygon is not quite a circle.
        EXPECT_NEAR(
            angles[i] - angles[i - 1], 2.0 * M_PI / static_cast<double>(angles.size()), 1e-4);
    }
}

TEST(SampleSets, OfTheStarKeepTheirPromises)
{
    const TriangleMesh mesh = star();
    for (const SurfaceSamples& set : sampleSurfaceSets(mesh, spaced(kSpacing), 6))
    {
        expectPromises(mesh, set, kSpacing);
    }
}

TEST(SampleSets, RefusesCountsThatMakeNoSense)
{
    const auto errorOfSets = [](const SamplerOptions& options, int count)
    {
        try
        {
            sampleSurfaceSets(star(), options, count);
        }
        catch (const base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(errorOfSets(spaced(kSpacing), 0),
              "The number of sample sets is 0; it must be in 1 .. 1024");
    EXPECT_EQ(errorOfSets(spaced(kSpacing, Sampling::VERTICES), 2),
              "A mesh has one set of vertices; 2 sample sets need its surface or its edges");
}

} // namespace midair::haptics
