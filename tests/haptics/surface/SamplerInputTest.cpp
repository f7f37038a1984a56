#include "haptics/surface/SurfaceSampler.h"
#include "tests/haptics/surface/SamplerChecks.h"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{

using namespace test;

TEST(SamplerInput, WeldsDoubledVertices)
{
    // A box whose faces share no vertices, as exporters write it: the same points come as for the
    // shared ones.
    const TriangleMesh shared = box({0.06, 0.05, 0.04});
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3i> triangles;
    for (const auto& t : shared.triangles.colwise())
    {
        const int first = static_cast<int>(vertices.size());
        for (const int v : t)
            vertices.emplace_back(shared.vertices.col(v));
        triangles.emplace_back(first, first + 1, first + 2);
    }
    const SurfaceSamples a = sampleSurface(shared, spaced(kSpacing));
    const SurfaceSamples b = sampleSurface(makeMesh(vertices, triangles), spaced(kSpacing));
    for (int v = 0; v < 8; ++v)
        EXPECT_TRUE(holds(b, shared.vertices.col(v))) << v;
    // Welded: the diagonals across the faces are no features, so no more points lie on them than
    // before.
    SamplerOptions edges = spaced(kSpacing, Sampling::EDGES);
    EXPECT_EQ(sampleSurface(makeMesh(vertices, triangles), edges).size(),
              sampleSurface(shared, edges).size());
    EXPECT_NEAR(a.size(), b.size(), 0.1 * a.size());
}

TEST(SamplerInput, ASpacingLargerThanTheObjectGivesOnePoint)
{
    EXPECT_EQ(sampleSurface(box({0.01, 0.01, 0.01}), spaced(0.5)).size(), 1);
    EXPECT_EQ(sampleSurface(sphere(0.01, 3), spaced(0.5)).size(), 1);
    EXPECT_EQ(sampleSurface(sphere(0.01, 3), spaced(1e300)).size(), 1);
    EXPECT_EQ(sampleSurface(disc(0.01, 90), spaced(0.5, Sampling::EDGES)).size(), 1);
    EXPECT_EQ(sampleSurface(star(), spaced(0.5, Sampling::VERTICES)).size(), 1);
}

TEST(SamplerInput, PassesOverTrianglesWithoutArea)
{
    TriangleMesh mesh = star();
    const SurfaceSamples before = sampleSurface(mesh, spaced(kSpacing));
    const Eigen::Index count = mesh.triangles.cols();
    mesh.triangles.conservativeResize(3, count + 3);
    mesh.triangles.col(count) = Eigen::Vector3i(0, 0, 1);
    mesh.triangles.col(count + 1) = Eigen::Vector3i(3, 3, 3);
    mesh.triangles.col(count + 2) = Eigen::Vector3i(4, 5, 4);
    EXPECT_EQ(sampleSurface(mesh, spaced(kSpacing)).positions, before.positions);
}

TEST(SamplerInput, IgnoresUnreferencedVertices)
{
    TriangleMesh mesh = star();
    const SurfaceSamples before = sampleSurface(mesh, spaced(kSpacing));
    mesh.vertices.conservativeResize(3, 13);
    mesh.vertices.col(11).setConstant(1e300);
    mesh.vertices.col(12).setConstant(-1e-300);
    EXPECT_EQ(sampleSurface(mesh, spaced(kSpacing)).positions, before.positions);
    EXPECT_EQ(sampleSurface(mesh, spaced(kSpacing, Sampling::VERTICES)).size(), 11);
}

TEST(SamplerInput, TakesNonManifoldMeshes)
{
    // Three sheets on one edge, one of them wound the other way, and one sheet twice.
    const TriangleMesh mesh =
        makeMesh({{0, 0, 0}, {0.1, 0, 0}, {0.05, 0.05, 0}, {0.05, -0.05, 0}, {0.05, 0, 0.06}},
                 {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 4}});
    const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
    expectPromises(mesh, samples, kSpacing);
    EXPECT_TRUE(holds(samples, mesh.vertices.col(0)));
}

TEST(SamplerInput, TakesScalesThatDifferWildly)
{
    // A 100 m floor in one triangle would be 1e8 points; a sliver of one and a 1 um grain are not.
    TriangleMesh mesh = makeMesh(
        {{0, 0, 0}, {10.0, 0, 0}, {0, 1e-4, 0}, {5, 1, 0}, {5 + 1e-6, 1, 0}, {5, 1 + 1e-6, 0}},
        {{0, 1, 2}, {3, 4, 5}});
    const SurfaceSamples samples = sampleSurface(mesh, spaced(kSpacing));
    expectPromises(mesh, samples, kSpacing);
    EXPECT_TRUE(((samples.positions.row(1).array() - 1.0).abs() < 1e-5).any());
}

TEST(SamplerInput, RefusesWhatItCantSample)
{
    const TriangleMesh mesh = star();
    const SamplerOptions options = spaced(kSpacing);
    EXPECT_EQ(errorOf(TriangleMesh(), options), "The mesh has no triangles");
    TriangleMesh bad = mesh;
    bad.vertices(1, 7) = std::nan("");
    EXPECT_EQ(errorOf(bad, options), "Vertex 7 of the mesh is not finite");
    bad = mesh;
    bad.vertices(1, 7) = std::numeric_limits<double>::infinity();
    EXPECT_EQ(errorOf(bad, options), "Vertex 7 of the mesh is not finite");
    bad = mesh;
    bad.vertices(1, 7) = 1e20;
    EXPECT_EQ(errorOf(bad, options), "Vertex 7 of the mesh is farther than 1e9 m from the origin");
    bad = mesh;
    bad.triangles(2, 4) = 11;
    EXPECT_EQ(errorOf(bad, options), "Triangle 4 of the mesh refers to vertex 11; there are 11");
    bad.triangles(2, 4) = -1;
    EXPECT_EQ(errorOf(bad, options), "Triangle 4 of the mesh refers to vertex -1; there are 11");
    bad = mesh;
    bad.intensity = Eigen::VectorXf::Ones(3);
    EXPECT_EQ(errorOf(bad, options), "The mesh has 3 intensities for 11 vertices");
    EXPECT_EQ(
        errorOf(sphere(0.03, 4), spaced(kSpacing, Sampling::EDGES)),
        "The mesh has no edges to sample: it is closed and no edge turns by more than 34.9504 "
        "degrees; sample its surface, or make the crease angle smaller");
    EXPECT_EQ(errorOf(mesh, spaced(1e-30)).find("A spacing of 1e-30 m needs about "), 0U);
}

TEST(SamplerInput, ValidatesItsOptions)
{
    const TriangleMesh mesh = star();
    EXPECT_EQ(errorOf(mesh, spaced(0.0)), "SamplerOptions::spacing_m is 0; it must be above 0");
    EXPECT_EQ(errorOf(mesh, spaced(-1.0)), "SamplerOptions::spacing_m is -1; it must be above 0");
    EXPECT_EQ(errorOf(mesh, spaced(std::nan(""))),
              "SamplerOptions::spacing_m is nan; it must be above 0");
    SamplerOptions options;
    options.creaseAngle_rad = 4.0;
    EXPECT_EQ(errorOf(mesh, options),
              "SamplerOptions::creaseAngle_rad is 4; it must be within 0 .. pi");
    options = {};
    options.edgeSpacing_m = 0.5;
    EXPECT_EQ(errorOf(mesh, options),
              "SamplerOptions::edgeSpacing_m is 0.5; it must be within 0 .. spacing_m");
    options = {};
    options.maxPoints = 0;
    EXPECT_EQ(errorOf(mesh, options), "SamplerOptions::maxPoints is 0; it must be at least 1");
}

TEST(SamplerInput, TellsASpacingThatWouldDo)
{
    for (const TriangleMesh& mesh :
         {star(), sphere(0.04, 3), box({0.3, 0.002, 0.002}), triangleSoup(0.1, 60, 3)})
    {
        for (const Sampling sampling : {Sampling::SURFACE, Sampling::EDGES})
        {
            SamplerOptions options = spaced(1e-4, sampling);
            options.maxPoints = 500;
            const std::string error = errorOf(mesh, options);
            if (sampling == Sampling::EDGES && error.find("no edges") != std::string::npos)
                continue;
            EXPECT_EQ(error.find("A spacing of 0.0001 m needs about "), 0U) << error;
            const std::string mark = "a spacing of ";
            const std::size_t at = error.find(mark);
            ASSERT_NE(at, std::string::npos) << error;
            options.spacing_m = std::stod(error.substr(at + mark.size()));
            EXPECT_LE(sampleSurface(mesh, options).size(), 500) << error;
        }
    }
}

} // namespace midair::haptics
