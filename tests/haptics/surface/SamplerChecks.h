#pragma once

#include "haptics/base/InputError.h"
#include "haptics/surface/ObjReader.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <string>

#include <gtest/gtest.h>

/// What the sampler's tests have in common.
namespace midair::haptics::test
{

constexpr double kSpacing = 8.5e-3;

inline TriangleMesh star()
{
    return readObj(MIDAIR_ROOT "/samples/models/star.obj");
}

inline SamplerOptions spaced(double spacing, Sampling sampling = Sampling::SURFACE)
{
    SamplerOptions options;
    options.spacing_m = spacing;
    options.sampling = sampling;
    return options;
}

inline std::string errorOf(const TriangleMesh& mesh, const SamplerOptions& options)
{
    try
    {
        sampleSurface(mesh, options);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

inline bool holds(const SurfaceSamples& samples, const Eigen::Vector3d& point)
{
    return (samples.positions.colwise() - point).colwise().norm().minCoeff() < 1e-12;
}

/// The three promises, each by brute force, and that the members agree with each other.
inline void expectPromises(const TriangleMesh& mesh,
                           const SurfaceSamples& samples,
                           double spacing,
                           double step = 0.0)
{
    ASSERT_GT(samples.size(), 0);
    ASSERT_EQ(samples.normals.cols(), samples.size());
    ASSERT_EQ(samples.barycentric.cols(), samples.size());
    ASSERT_EQ(static_cast<int>(samples.triangle.size()), samples.size());
    ASSERT_EQ(samples.intensity.size(), samples.size());
    ASSERT_EQ(static_cast<int>(samples.normalStart.size()), samples.size() + 1);
    EXPECT_TRUE(samples.positions.allFinite());
    // Normalising leaves a few roundings.
    EXPECT_LT((samples.normals.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-14);
    EXPECT_LT((samples.barycentric.colwise().sum().array() - 1.0).abs().maxCoeff(), 1e-14);
    EXPECT_GE(samples.barycentric.minCoeff(), 0.0);
    // Barycentric combinations round in the last bits of the coordinates.
    EXPECT_LT(farthestOffSurface(mesh, samples.positions),
              1e-14 + 1e-15 * mesh.extent().maxCoeff());
    EXPECT_GE(smallestDistance(samples.positions), spacing);
    EXPECT_LE(largestGap(mesh, samples.positions, step > 0.0 ? step : spacing / 12.0),
              1.1 * spacing);
}

/// m; the mean over the points of the distance to the nearest other one.
inline double meanNearestDistance(const Eigen::Matrix3Xd& points)
{
    double sum = 0.0;
    for (Eigen::Index i = 0; i < points.cols(); ++i)
    {
        Eigen::VectorXd distance2 = (points.colwise() - points.col(i)).colwise().squaredNorm();
        distance2[i] = std::numeric_limits<double>::infinity();
        sum += std::sqrt(distance2.minCoeff());
    }
    return sum / static_cast<double>(points.cols());
}

} // namespace midair::haptics::test
