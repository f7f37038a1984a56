#include "haptics/surface/SurfaceSampler.h"

#include "haptics/surface/ObjReader.h"
#include "tests/haptics/surface/SamplerChecks.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{

using namespace test;

TEST(SurfaceSampler, KeepsItsPromisesOnTheStar)
{
    const TriangleMesh mesh = star();
    for (const double spacing : {3e-3, 5e-3, kSpacing, 20e-3})
    {
        SCOPED_TRACE(spacing);
        const SurfaceSamples samples = sampleSurface(mesh, spaced(spacing));
        expectPromises(mesh, samples, spacing);
        // All tips and notches are a spacing apart, so all are kept.
        for (int v = 0; v < 10; ++v)
            EXPECT_TRUE(holds(samples, mesh.vertices.col(v))) << v;
    }
}

TEST(SurfaceSampler, KeepsItsPromisesOnBoxesAndPlates)
{
    for (const Eigen::Vector3d& size : {Eigen::Vector3d(0.06, 0.06, 0.06),
                                        Eigen::Vector3d(0.08, 0.05, 0.001),
                                        Eigen::Vector3d(0.08, 0.05, 1e-6),
                                        Eigen::Vector3d(0.3, 0.002, 0.002),
                                        Eigen::Vector3d(0.012, 0.009, 0.03)})
    {
        SCOPED_TRACE(size.transpose());
        const TriangleMesh mesh = box(size);
        expectPromises(mesh, sampleSurface(mesh, spaced(kSpacing)), kSpacing);
    }
}

TEST(SurfaceSampler, KeepsItsPromisesOnASphere)
{
    const TriangleMesh mesh = sphere(0.03, 4);
    const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
    expectPromises(mesh, samples, kSpacing, 1e-3);
    // A maximal set takes 0.65 to 0.78 points in the spacing's square.
    const double density = samples.size() * kSpacing * kSpacing / (4.0 * M_PI * 0.03 * 0.03);
    EXPECT_GT(density, 0.62);
    EXPECT_LT(density, 0.85);
    for (int i = 0; i < samples.size(); ++i)
    {
        // Faces of this sphere are tilted by up to 3 degrees from the radius.
        EXPECT_GT(samples.normals.col(i).dot(samples.positions.col(i).normalized()), 0.99);
    }
}

TEST(SurfaceSampler, KeepsItsPromisesOnTriangleSoup)
{
    for (unsigned seed = 1; seed <= 6; ++seed)
    {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = triangleSoup(0.1, 40, seed);
        expectPromises(mesh, sampleSurface(mesh, spaced(kSpacing)), kSpacing);
    }
}

TEST(SurfaceSampler, KeepsItsPromisesOnSlivers)
{
    // A strip cut into a fan of slivers, the thinnest 1e-7 m high and 0.2 m long.
    std::vector<Eigen::Vector3d> vertices = {{0, 0, 0}};
    std::vector<Eigen::Vector3i> triangles;
    for (int i = 0; i <= 20; ++i)
        vertices.emplace_back(0.2, 1e-7 * std::pow(1.8, i), 0.01 * (i % 2));
    for (int i = 1; i <= 20; ++i)
        triangles.emplace_back(0, i, i + 1);
    const TriangleMesh mesh = makeMesh(vertices, triangles);
    expectPromises(mesh, sampleSurface(mesh, spaced(kSpacing)), kSpacing);
}

TEST(SurfaceSampler, KeepsItsPromisesOnTheSharedMeshes)
{
    const std::filesystem::path folder = MIDAIR_ROOT "/../shared/meshes";
    if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no ../shared/meshes";
    for (const auto& file : std::filesystem::directory_iterator(folder))
    {
        if (file.path().extension() != ".obj") continue;
        SCOPED_TRACE(file.path());
        const TriangleMesh mesh = readObj(file.path()).scaledTo(0.08);
        const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
        expectPromises(mesh, samples, kSpacing, 1.5e-3);
        RecordProperty(file.path().stem().string(), samples.size());
    }
}

TEST(SurfaceSampler, KeepsSharpTipsBeforeNotches)
{
    // At 30 mm the notches (28.3 mm from each other, 28.4 mm from the raised centre) can't stay
    // beside sharper corners.
    const TriangleMesh mesh = star();
    const SurfaceSamples samples = sampleSurface(mesh, spaced(30e-3));
    int notches = 0;
    for (int v = 0; v < 10; v += 2)
        EXPECT_TRUE(holds(samples, mesh.vertices.col(v))) << v;
    for (int v = 1; v < 10; v += 2)
        notches += holds(samples, mesh.vertices.col(v)) ? 1 : 0;
    EXPECT_TRUE(holds(samples, mesh.vertices.col(10)));
    EXPECT_EQ(notches, 0);
    expectPromises(mesh, samples, 30e-3, 1e-3);
}

TEST(SurfaceSampler, KeepsTheTipOfACone)
{
    TriangleMesh cone = disc(0.03, 48);
    cone.vertices(2, 0) = 0.05;
    // No two faces turn by the crease angle there, yet it is a tip.
    EXPECT_TRUE(holds(sampleSurface(cone, spaced(kSpacing)), cone.vertices.col(0)));
}

TEST(SurfaceSampler, IsRepeatableAndSeeded)
{
    const TriangleMesh mesh = sphere(0.03, 3);
    SamplerOptions options = spaced(kSpacing);
    const SurfaceSamples a = sampleSurface(mesh, options);
    const SurfaceSamples b = sampleSurface(mesh, options);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.triangle, b.triangle);
    options.seed = 2;
    EXPECT_FALSE(a.positions.leftCols(5) == sampleSurface(mesh, options).positions.leftCols(5));
}

TEST(SurfaceSampler, SamplesVertices)
{
    const TriangleMesh mesh = star();
    const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing, Sampling::VERTICES));
    EXPECT_EQ(samples.size(), 11); // the paper's eleven
    for (int v = 0; v < 11; ++v)
        EXPECT_TRUE(holds(samples, mesh.vertices.col(v))) << v;
    // Vertices nearer than the spacing are thinned: no two left nearer, none left out that had
    // room.
    const TriangleMesh ball = sphere(0.03, 4);
    const SurfaceSamples thinned = sampleSurface(ball, spaced(kSpacing, Sampling::VERTICES));
    EXPECT_GE(smallestDistance(thinned.positions), kSpacing);
    for (const auto& vertex : ball.vertices.colwise())
    {
        EXPECT_LT((thinned.positions.colwise() - vertex).colwise().norm().minCoeff(),
                  kSpacing * (1.0 + 1e-8));
    }
}

TEST(SurfaceSampler, StepsEquallyRoundAClosedLoop)
{
    const double radius = 0.05;
    const TriangleMesh mesh = disc(radius, 720);
    for (const double edgeSpacing : {0.0, 4.3e-3, 2.2e-3})
    {
        SamplerOptions options = spaced(8.6e-3, Sampling::EDGES);
        options.edgeSpacing_m = edgeSpacing;
        const double asked = edgeSpacing > 0.0 ? edgeSpacing : options.spacing_m;
        const SurfaceSamples samples = sampleSurface(mesh, options);
        std::vector<double> angles;
        for (const auto& point : samples.positions.colwise())
        {
            EXPECT_NEAR(point.norm(), radius, radius * 1e-5); // chords of a 720-gon
            angles.push_back(std::atan2(point.y(), point.x()));
        }
        std::sort(angles.begin(), angles.end());
        const double step = 2.0 * M_PI / samples.size();
        // The most that fit: one more would come too near.
        EXPECT_EQ(samples.size(), static_cast<int>(M_PI / std::asin(0.5 * asked / radius)));
        for (std::size_t i = 1; i < angles.size(); ++i)
        {
            EXPECT_NEAR(angles[i] - angles[i - 1], step, 1e-4); // the polygon is not quite a circle
        }
        EXPECT_GE(smallestDistance(samples.positions), asked);
    }
}

TEST(SurfaceSampler, EdgesLieOnFeaturesAndLeaveNoGap)
{
    const TriangleMesh mesh = box({0.06, 0.05, 0.04});
    SamplerOptions options = spaced(kSpacing, Sampling::EDGES);
    options.edgeSpacing_m = 4e-3;
    const SurfaceSamples samples = sampleSurface(mesh, options);
    EXPECT_GE(smallestDistance(samples.positions), 4e-3);
    const Eigen::Vector3d half(0.03, 0.025, 0.02);
    for (const auto& point : samples.positions.colwise())
    {
        int onFaces = 0;
        for (int k = 0; k < 3; ++k)
            onFaces += std::abs(std::abs(point[k]) - half[k]) < 1e-12 ? 1 : 0;
        EXPECT_GE(onFaces, 2);
    }
    for (int i = 0; i <= 1000; ++i)
    {
        const Eigen::Vector3d spot(-0.03 + 6e-5 * i, 0.025, -0.02);
        EXPECT_LE((samples.positions.colwise() - spot).colwise().norm().minCoeff(), 1.1 * 4e-3);
    }
}

TEST(SurfaceSampler, DenserEdgesKeepTheFacesApart)
{
    const TriangleMesh mesh = star();
    SamplerOptions options = spaced(kSpacing);
    options.edgeSpacing_m = 3e-3;
    const SurfaceSamples samples = sampleSurface(mesh, options);
    EXPECT_GE(smallestDistance(samples.positions), 3e-3);
    EXPECT_LE(largestGap(mesh, samples.positions, 0.5e-3), 1.1 * kSpacing);
    for (int i = 0; i < samples.size(); ++i)
    {
        const bool insideFace = samples.barycentric.col(i).minCoeff() > 0.0;
        if (!insideFace) continue;
        Eigen::Matrix3Xd others = samples.positions;
        others.col(i).setConstant(1.0);
        EXPECT_GE((others.colwise() - samples.positions.col(i)).colwise().norm().minCoeff(),
                  kSpacing);
    }
}

TEST(SurfaceSampler, CarriesTheIntensity)
{
    TriangleMesh mesh = disc(0.03, 30);
    mesh.intensity = mesh.vertices.colwise().norm().cast<float>() / 0.03F;
    const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
    for (int i = 0; i < samples.size(); ++i)
    {
        // Linear on each of the 30 sectors: at most 1 - cos(6 degrees) above the radius.
        EXPECT_NEAR(samples.intensity[i], samples.positions.col(i).norm() / 0.03, 0.006);
    }
}

TEST(SurfaceSampler, UpdatesSamplesOfADeformedMesh)
{
    const TriangleMesh mesh = star();
    SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
    const SurfaceSamples before = samples;
    updateSamples(mesh, samples);
    EXPECT_EQ(samples.positions, before.positions);
    EXPECT_EQ(samples.normals, before.normals);

    const Eigen::AngleAxisd turn(0.7, Eigen::Vector3d(1, 2, 3).normalized());
    TriangleMesh turned = mesh;
    turned.vertices = turn.toRotationMatrix() * mesh.vertices;
    const double* data = samples.positions.data();
    updateSamples(turned, samples);
    EXPECT_EQ(samples.positions.data(), data);
    // A rotation rounds in the last bits.
    EXPECT_LT((samples.positions - turn.toRotationMatrix() * before.positions).norm(), 1e-13);
    EXPECT_LT((samples.normals - turn.toRotationMatrix() * before.normals).norm(), 1e-12);

    TriangleMesh flat = mesh;
    flat.vertices.setZero();
    updateSamples(flat, samples);
    EXPECT_EQ(samples.positions.norm(), 0.0);
    EXPECT_LT((samples.normals.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-14);

    TriangleMesh other = disc(0.03, 5);
    try
    {
        updateSamples(other, samples);
        FAIL() << "no error";
    }
    catch (const base::InputError& error)
    {
        EXPECT_NE(std::string(error.what()).find("the deformed mesh has 5"), std::string::npos)
            << error.what();
    }
}

TEST(SurfaceSampler, NormalsOnEdgesLieBetweenTheFaces)
{
    const TriangleMesh mesh = box({0.06, 0.05, 0.04});
    const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
    // The first eight points are the corners: the normal is the diagonal whichever way the faces
    // are cut.
    for (int i = 0; i < 8; ++i)
    {
        const Eigen::Vector3d diagonal =
            samples.positions.col(i).array().sign().matrix() / std::sqrt(3.0);
        EXPECT_LT((samples.normals.col(i) - diagonal).norm(), 1e-14);
    }
}

} // namespace midair::haptics
