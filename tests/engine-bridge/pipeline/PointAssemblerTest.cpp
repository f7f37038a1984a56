#include "engine-bridge/pipeline/PointAssembler.h"

#include "tests/engine-bridge/pipeline/Fakes.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

struct Assembler : testing::Test
{
    explicit Assembler(int maxPoints = 0)
    {
        PointAssembler::Options options;
        options.wavelength_m = 8.58e-3;
        options.maxPoints = maxPoints;
        assembler = std::make_unique<PointAssembler>(array, options, messages);
    }

    haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    midair::base::MessageLog messages;
    std::unique_ptr<PointAssembler> assembler;
};

struct AssemblerOfFifty : Assembler
{
    AssemblerOfFifty() : Assembler(50) {}
};

/// The square turned to face the board, 150 mm above it.
SceneSnapshot facing(double turn_rad = 0.0)
{
    SceneSnapshot snapshot = squareSnapshot();
    Eigen::Isometry3d& pose = snapshot.objects[0].pose;
    pose.translation().z() = 0.15;
    pose.linear() =
        Eigen::AngleAxisd(0.5 * M_PI + turn_rad, Eigen::Vector3d::UnitX()).toRotationMatrix();
    return snapshot;
}

SceneSnapshot withVertices(const Eigen::Matrix3Xd& vertices, std::uint64_t meshId)
{
    SceneSnapshot snapshot = facing();
    auto mesh = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
    mesh->vertices = vertices;
    snapshot.objects[0].mesh = mesh;
    snapshot.objects[0].meshId = meshId;
    snapshot.objects[0].topologyId = 5;
    return snapshot;
}

} // namespace

TEST_F(Assembler, FrontAndBackAreTheTwoSidesOfASheet)
{
    SceneSnapshot snapshot = facing();
    const int both = assembler->assemble(snapshot).points.size();
    snapshot.objects[0].properties.side = Side::FRONT;
    const int front = assembler->assemble(snapshot).points.size();
    snapshot.objects[0].properties.side = Side::BACK;
    const int back = assembler->assemble(snapshot).points.size();
    EXPECT_GT(both, 15);
    EXPECT_EQ(std::max(front, back), both) << "all of it faces one way";
    EXPECT_EQ(std::min(front, back), 0);
    SceneSnapshot turned = facing(M_PI);
    turned.objects[0].properties.side = front > 0 ? Side::FRONT : Side::BACK;
    EXPECT_EQ(assembler->assemble(turned).points.size(), 0) << "turned over, the other side faces";
}

TEST_F(Assembler, WhatIsOutOfReachIsNotEvenSampled)
{
    SceneSnapshot far = facing();
    far.objects[0].pose.translation().z() = 30.0;
    const AssembledPoints out = assembler->assemble(far);
    EXPECT_EQ(out.points.size(), 0);
    EXPECT_EQ(out.outOfWorkspace, 1u);
    EXPECT_EQ(assembler->sampled(), 0u);
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_EQ(messages.all()[0],
              "Scene/Square: is out of the array's reach; it can't be felt there");
    EXPECT_TRUE(assembler->unmoved(far));
    EXPECT_FALSE(assembler->unmoved(facing())) << "back in reach";
    EXPECT_GT(assembler->assemble(facing()).points.size(), 0);
}

TEST_F(Assembler, WhatIsBehindTheBoardIsSkippedAndNamed)
{
    SceneSnapshot behind = facing();
    behind.objects[0].pose.translation().z() = -0.15;
    const AssembledPoints out = assembler->assemble(behind);
    EXPECT_EQ(out.points.size(), 0);
    EXPECT_GT(out.skipped.cols(), 15);
    EXPECT_EQ(out.outOfWorkspace, static_cast<std::uint64_t>(out.skipped.cols()));
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_EQ(
        messages.all()[0].rfind("Scene/Square: none of its points can be felt where it is (", 0),
        0u);
}

TEST_F(AssemblerOfFifty, TheBudgetGoesToThePriorities)
{
    SceneSnapshot snapshot = facing();
    snapshot.objects[0].mesh = squareMesh(0.06);
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[0].pose.translation().x() = -0.05;
    snapshot.objects[1].pose.translation().x() = 0.05;
    snapshot.objects[1].properties.priority = 1;
    const AssembledPoints out = assembler->assemble(snapshot);
    EXPECT_EQ(out.points.size(), 50);
    EXPECT_GT(out.overBudget, 0u);
    EXPECT_EQ(static_cast<std::uint64_t>(out.skipped.cols()), out.overBudget);
    const auto& object = out.points.object;
    EXPECT_GT(std::count(object.begin(), object.end(), 1),
              std::count(object.begin(), object.end(), 0));
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_EQ(messages.all()[0],
              "more points than the budget of 50; objects of lower priority get fewer");
}

TEST_F(Assembler, WhatIsPaintedOutIsCounted)
{
    SceneSnapshot snapshot = facing();
    auto mesh = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
    mesh->intensity = Eigen::Vector4f(0.0f, 0.0f, 0.0f, 1.0f); // one of two triangles
    const int whole = assembler->assemble(snapshot).points.size();
    snapshot.objects[0].mesh = mesh;
    snapshot.objects[0].meshId = 7;
    const AssembledPoints out = assembler->assemble(snapshot);
    EXPECT_GT(out.unpainted, 5u);
    EXPECT_GT(out.points.size(), 5);
    EXPECT_EQ(out.unpainted + static_cast<std::uint64_t>(out.points.size()),
              static_cast<std::uint64_t>(whole));
}

TEST_F(Assembler, WhatAnotherObjectsPointsLeaveNoRoomForIsCounted)
{
    SceneSnapshot snapshot = facing();
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[1].pose.translation().x() += 0.001;
    const AssembledPoints one = assembler->assemble(facing());
    const AssembledPoints out = assembler->assemble(snapshot);
    EXPECT_EQ(one.crowded, 0u);
    EXPECT_GT(out.crowded, static_cast<std::uint64_t>(one.points.size()) / 2);
    EXPECT_EQ(out.crowded + static_cast<std::uint64_t>(out.points.size()),
              2u * static_cast<std::uint64_t>(one.points.size()));
}

TEST_F(Assembler, PointsFollowAMorphingMeshByTheirBarycentrics)
{
    const Eigen::Matrix3Xd rest = squareMesh()->vertices;
    const AssembledPoints before = assembler->assemble(withVertices(rest, 10));
    Eigen::Matrix3Xd bent = rest;
    bent.row(1) += 0.1 * rest.row(0); // a shear by a tenth: edges grow by 0.5 % at most
    const AssembledPoints after = assembler->assemble(withVertices(bent, 11));
    EXPECT_EQ(assembler->sampled(), 1u);
    EXPECT_EQ(assembler->followed(), 1u);
    ASSERT_EQ(after.points.size(), before.points.size());
    const Eigen::Isometry3d back = facing().objects[0].pose.inverse();
    const Eigen::Matrix3Xd was = back * before.points.positions;
    const Eigen::Matrix3Xd is = back * after.points.positions;
    // Barycentrics of an affine map: exact but for rounding.
    EXPECT_LT((is.row(1) - 0.1 * was.row(0)).norm(), 1e-12);
    EXPECT_LT((is.row(0) - was.row(0)).norm(), 1e-12);
}

TEST_F(Assembler, AStretchedMeshIsSampledAgain)
{
    const Eigen::Matrix3Xd rest = squareMesh()->vertices;
    const int before = assembler->assemble(withVertices(rest, 10)).points.size();
    const int little = assembler->assemble(withVertices(1.2 * rest, 11)).points.size();
    EXPECT_EQ(little, before) << "a fifth: they follow";
    const int much = assembler->assemble(withVertices(1.44 * rest, 12)).points.size();
    EXPECT_GT(much, before) << "a fifth of what had followed: measured from when it was sampled";
    EXPECT_EQ(assembler->sampled(), 2u);
    EXPECT_EQ(assembler->followed(), 1u);
}
