#include "haptics/sequence/FocusShare.h"

#include "haptics/points/FittingSize.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/SurfaceSampler.h"

#include <numeric>
#include <string>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

/// A plate or a box of \a extent_m.
TriangleMesh box(const Eigen::Vector3d& extent_m)
{
    TriangleMesh mesh;
    mesh.vertices.resize(3, 8);
    for (int i = 0; i < 8; ++i)
        mesh.vertices.col(i) =
            extent_m.cwiseProduct(Eigen::Vector3d(i & 1, (i >> 1) & 1, (i >> 2) & 1)) -
            0.5 * extent_m;
    mesh.triangles.resize(3, 12);
    mesh.triangles << 0, 1, 4, 5, 0, 1, 2, 3, 0, 2, 1, 3, //
        1, 3, 5, 7, 1, 5, 3, 7, 2, 6, 3, 7,               //
        2, 2, 6, 6, 4, 4, 6, 6, 4, 4, 5, 5;
    return mesh;
}

ControlPoints sampled(const TriangleMesh& mesh, const Eigen::Vector3d& place, Sampling sampling)
{
    SamplerOptions options;
    options.sampling = sampling;
    const SurfaceSamples samples = sampleSurface(mesh, options);
    ControlPoints points;
    points.positions = samples.positions.colwise() + place;
    points.normals = samples.normals;
    points.targets = Eigen::VectorXd::Ones(points.size());
    return points;
}

} // namespace

// Against the whole object as the default solver plays it, of many sizes, on arrays around it and
// below it.
TEST(FocusShare, IsAtMostWhatOnePointOfTheWholeGets)
{
    double closest = 0.0;
    for (const auto& [array, place] :
         {std::pair(TransducerArray::octagonalPrism(), Eigen::Vector3d(0, 0, 0)),
          std::pair(TransducerArray::singleBoard(), Eigen::Vector3d(0, 0, 0.15))})
        for (const Eigen::Vector3d& shape : {Eigen::Vector3d(1, 1, 1),
                                             Eigen::Vector3d(1, 0.6, 0),
                                             Eigen::Vector3d(1, 0, 0.8),
                                             Eigen::Vector3d(1, 0.05, 0.05)})
            for (const double size_m : {0.02, 0.05, 0.1})
                for (const Sampling sampling : {Sampling::SURFACE, Sampling::EDGES})
                {
                    const ControlPoints whole = sampled(box(size_m * shape), place, sampling);
                    Eigen::VectorXcf q;
                    const SolveReport report =
                        makeSolver(solverNames().front())->solve(whole, array, Medium(), q);
                    ASSERT_GT(report.level_Pa, 0.0);
                    ControlPoints focus;
                    focus.positions = place;
                    focus.normals = Eigen::Vector3d::UnitZ();
                    focus.targets = Eigen::VectorXd::Ones(1);
                    holdToShare({0}, whole.size(), 1.0, array, Medium(), focus);
                    EXPECT_TRUE(focus.absolute);
                    const double share = focus.targets[0] / report.level_Pa;
                    EXPECT_LE(share, 1.0) << array.size() << " " << shape.transpose() << " "
                                          << size_m << " " << whole.size();
                    closest = std::max(closest, share);
                }
    EXPECT_GT(closest, 0.5) << "it isn't silenced";
}

TEST(FocusShare, TargetsInPaAreLoweredAndNeverRaised)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points;
    points.positions = Eigen::Matrix3Xd::Zero(3, 2);
    points.positions(0, 1) = 0.02;
    points.normals = Eigen::Vector3d::UnitZ().replicate(1, 2);
    points.targets = Eigen::Vector2d(1e5, 30.0);
    points.absolute = true;
    holdToShare({0, 1}, 200, 1.0, array, Medium(), points);
    EXPECT_LT(points.targets[0], 5000.0);
    EXPECT_GT(points.targets[0], 200.0);
    EXPECT_EQ(points.targets[1], 30.0);
    // Beside others relative ones stay relative, and share what all get.
    points.absolute = false;
    points.targets = Eigen::Vector2d(1.0, 1.0);
    holdToShare({0}, 31, 1.0, array, Medium(), points);
    EXPECT_FALSE(points.absolute);
    EXPECT_DOUBLE_EQ(points.targets[0], std::sqrt(2.0 / 32.0));
    EXPECT_EQ(points.targets[1], 1.0);
    // A quiet scene is a quiet one of this, too.
    ControlPoints loud = pick(points, {0});
    ControlPoints quiet = loud;
    holdToShare({0}, 100, 1.0, array, Medium(), loud);
    holdToShare({0}, 100, 0.25, array, Medium(), quiet);
    EXPECT_DOUBLE_EQ(quiet.targets[0], 0.25 * loud.targets[0]);
    holdToShare({}, 0, 1.0, array, Medium(), points);
    EXPECT_EQ(points.targets[1], 1.0) << "nothing is small";
}
