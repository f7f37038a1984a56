#include "haptics/points/FittingSize.h"

#include "haptics/points/ControlPointSelector.h"

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

constexpr double kWavelength_m = 8.58e-3;

/// The faces of a cube, as large as \a size_m.
TriangleMesh cube(double size_m)
{
    TriangleMesh mesh;
    mesh.vertices.resize(3, 8);
    for (int i = 0; i < 8; ++i)
        mesh.vertices.col(i) = Eigen::Vector3d(i & 1, (i >> 1) & 1, (i >> 2) & 1) * size_m;
    mesh.triangles.resize(3, 12);
    mesh.triangles << 0, 1, 4, 5, 0, 1, 2, 3, 0, 2, 1, 3, //
        1, 3, 5, 7, 1, 5, 3, 7, 2, 6, 3, 7,               //
        2, 2, 6, 6, 4, 4, 6, 6, 4, 4, 5, 5;
    return mesh;
}

double fitting(const TransducerArray& array, double width_m, double spacing_m, int maxPoints = 1000)
{
    const TriangleMesh mesh = cube(width_m);
    const LargeModel model{mesh, Eigen::Isometry3d::Identity(), width_m, spacing_m};
    return fittingSize_m(model,
                         Workspace(array, kWavelength_m, SelectorOptions()),
                         ArrayFront(array.positions, array.normals),
                         maxPoints);
}

} // namespace

TEST(FittingSize, KeepsTheBudget)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    // Six faces of 0.1 m have some 815 points a wavelength apart; of 0.2 m four times as many.
    EXPECT_EQ(fitting(array, 1.0, kWavelength_m), 0.1);
    EXPECT_EQ(fitting(array, 300.0, kWavelength_m), 0.1) << "however large it is";
    EXPECT_EQ(fitting(array, 1.0, kWavelength_m, 4000), 0.2);
    EXPECT_EQ(fitting(array, 0.07, kWavelength_m), 0.05) << "never larger than it is";
}

TEST(FittingSize, IsWhatTheWorkspaceHasRoomFor)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const double size_m = fitting(array, 3.0, 0.0); // as of edges: the budget says nothing
    EXPECT_GT(size_m, 0.1);
    const Workspace workspace(array, kWavelength_m, SelectorOptions());
    EXPECT_LT(size_m, 2.0 * workspace.reach_m());
}

TEST(FittingSize, ARoomyCubeIsTheLargestThatFits)
{
    for (const TransducerArray& array :
         {TransducerArray::octagonalPrism(), TransducerArray::singleBoard()})
    {
        const Workspace workspace(array, kWavelength_m, SelectorOptions());
        const ArrayFront front(array.positions, array.normals);
        const double room_m = roomInside_m(workspace, front);
        EXPECT_GT(room_m, 0.05);
        EXPECT_TRUE(hasRoom(Eigen::Vector3d::Constant(room_m), workspace, front));
        const double more_m = room_m + 0.02 * workspace.reach_m();
        EXPECT_FALSE(hasRoom(Eigen::Vector3d::Constant(more_m), workspace, front));
    }
}

// What is larger has more points, each of them weaker.
TEST(FittingSize, TheProposedOneIsFeltBest)
{
    EXPECT_EQ(proposedSize_m(0.2), 0.08);
    EXPECT_EQ(proposedSize_m(0.05), 0.05) << "never more than fits";
    EXPECT_EQ(proposedSize_m(0.0), 0.0);
}

TEST(FittingSize, IsNoneWhereNothingFits)
{
    EXPECT_EQ(fitting(TransducerArray::octagonalPrism(), 1.0, 1e-5, 1), 0.0);
}

TEST(FittingSize, AnArrayThatFacesItselfHasNoWayAhead)
{
    Eigen::Matrix3Xd positions(3, 2);
    positions << -0.1, 0.1, 0.0, 0.0, 0.0, 0.0;
    Eigen::Matrix3Xd normals(3, 2);
    normals << 1.0, -1.0, 0.0, 0.0, 0.0, 0.0;
    const ArrayFront facing(positions, normals);
    EXPECT_EQ(facing.ahead, Eigen::Vector3d::Zero());
    EXPECT_EQ(facing.middle, Eigen::Vector3d::Zero());
    normals << 0.0, 0.0, 0.0, 0.0, 0.5, 1.0;
    EXPECT_EQ(ArrayFront(positions, normals).ahead, Eigen::Vector3d::UnitZ());
}

TEST(FittingSize, WhatIsTooSmallMayGrow)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Workspace workspace(array, kWavelength_m, SelectorOptions());
    const ArrayFront front(array.positions, array.normals);
    for (const double width_m : {1e-9, 4e-5, 1e-3})
    {
        const TriangleMesh mesh = cube(width_m);
        LargeModel model{mesh, Eigen::Isometry3d::Identity(), width_m, kWavelength_m};
        EXPECT_LE(fittingSize_m(model, workspace, front, 1000), width_m);
        model.mayGrow = true;
        EXPECT_EQ(fittingSize_m(model, workspace, front, 1000), 0.1) << width_m;
        EXPECT_TRUE(isOneFocus(mesh, kWavelength_m));
        SamplerOptions sampling;
        sampling.spacing_m = kWavelength_m;
        EXPECT_EQ(pointsAtSize(mesh, sampling, 0.1, 1000),
                  sampleSurface(cube(0.1), sampling).size());
        EXPECT_EQ(pointsAtSize(mesh, sampling, 0.1, 50), 50);
        EXPECT_EQ(pointsAtSize(mesh, sampling, 0.0, 50), 50) << "no size fits";
        EXPECT_EQ(pointsAtSize(mesh, sampling, 9.0, 50), 50) << "more than are sampled";
    }
    const TriangleMesh nothing = cube(0.0);
    EXPECT_TRUE(isOneFocus(nothing, kWavelength_m));
    LargeModel none{nothing, Eigen::Isometry3d::Identity(), 0.0};
    none.mayGrow = true;
    EXPECT_EQ(fittingSize_m(none, workspace, front, 1000), 0.0);
    EXPECT_FALSE(isOneFocus(cube(0.51 * kWavelength_m), kWavelength_m));
    EXPECT_TRUE(isOneFocus(cube(0.49 * kWavelength_m), kWavelength_m));
    TriangleMesh point = cube(1e-4); // given points mean what they are
    point.triangles = Eigen::Vector3i::Constant(3);
    EXPECT_FALSE(isOneFocus(point, kWavelength_m));
}
