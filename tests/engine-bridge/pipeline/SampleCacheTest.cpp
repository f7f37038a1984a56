#include "engine-bridge/pipeline/SampleCache.h"

#include "tests/haptics/surface/SphereMesh.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

constexpr double kSpacing_m = 0.005;

/// An object of its own, whose mesh nobody else has.
HapticObject ownSphere(std::uint64_t id)
{
    HapticObject object;
    object.id = object.meshId = object.topologyId = id;
    object.mesh = sphere(0.02, 12);
    return object;
}

} // namespace

TEST(SampleCache, EqualMeshesAreSampledOnce)
{
    SampleCache cache;
    const CachedSamples& first = cache.get(ownSphere(1), kSpacing_m);
    for (std::uint64_t id = 2; id <= 200; ++id)
        EXPECT_EQ(&cache.get(ownSphere(id), kSpacing_m), &first);
    EXPECT_EQ(cache.sampled(), 1u);
    EXPECT_GT(first.sets.front().size(), 10);
}

TEST(SampleCache, WhatDiffersInAnythingThatIsSampledIsSampledByItself)
{
    SampleCache cache;
    cache.get(ownSphere(1), kSpacing_m);
    cache.get(ownSphere(2), 2.0 * kSpacing_m);
    EXPECT_EQ(cache.sampled(), 2u) << "another spacing";
    HapticObject other = ownSphere(3);
    other.mesh = sphere(0.021, 12);
    cache.get(other, kSpacing_m);
    EXPECT_EQ(cache.sampled(), 3u) << "another size";
    const auto painted = sphere(0.02, 12);
    painted->intensity.setOnes(painted->vertices.cols());
    other = ownSphere(4);
    other.mesh = painted;
    cache.get(other, kSpacing_m);
    EXPECT_EQ(cache.sampled(), 4u) << "painted";
    const auto pictured = sphere(0.02, 12);
    const auto paint = std::make_shared<haptics::SurfacePaint>();
    paint->coordinates.setZero(2, pictured->vertices.cols());
    paint->image.assign(static_cast<std::size_t>(pictured->triangles.cols()), -1);
    pictured->paint = paint;
    other = ownSphere(5);
    other.mesh = pictured;
    cache.get(other, kSpacing_m);
    EXPECT_EQ(cache.sampled(), 5u) << "with a picture";
}

TEST(SampleCache, OneThatDeformsTakesItsSamplesAlong)
{
    SampleCache cache;
    const Eigen::Matrix3Xd before = cache.get(ownSphere(1), kSpacing_m).sets.front().positions;
    cache.get(ownSphere(2), kSpacing_m);
    HapticObject moved = ownSphere(2);
    moved.meshId = 3; // with the triangles of before
    moved.mesh = sphere(0.021, 12);
    const Eigen::Matrix3Xd after = cache.get(moved, kSpacing_m).sets.front().positions;
    EXPECT_EQ(cache.sampled(), 1u);
    EXPECT_EQ(cache.followed(), 1u);
    EXPECT_NEAR((after - before).colwise().norm().minCoeff(), 0.001, 1e-4);
    EXPECT_EQ(cache.get(ownSphere(1), kSpacing_m).sets.front().positions, before);
}
