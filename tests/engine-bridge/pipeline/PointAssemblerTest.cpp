#include "engine-bridge/pipeline/PointAssembler.h"

#include "haptics/points/FittingSize.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>
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

TEST_F(Assembler, LinesHaveBothSides)
{
    SceneSnapshot snapshot = facing();
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    mesh->vertices.resize(3, 2);
    mesh->vertices << -0.017, 0.017, 0.0, 0.0, 0.0, 0.0;
    mesh->triangles.resize(3, 1);
    mesh->triangles << 0, 1, 1;
    snapshot.objects[0].mesh = mesh;
    for (const Side side : {Side::BOTH, Side::FRONT, Side::BACK})
    {
        snapshot.objects[0].properties.side = side;
        EXPECT_EQ(assembler->assemble(snapshot).points.size(), 4);
    }
}

TEST_F(Assembler, GivenPointsAreNotThinned)
{
    SceneSnapshot snapshot = facing();
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    mesh->vertices.resize(3, 3);
    mesh->vertices << 0.0, 0.001, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
    mesh->triangles = Eigen::RowVector3i(0, 1, 2).replicate(3, 1);
    snapshot.objects[0].mesh = mesh;
    snapshot.objects[0].properties.sampling = haptics::Sampling::POINTS;
    const haptics::ControlPoints points = assembler->assemble(snapshot).points;
    ASSERT_EQ(points.size(), 3);
    EXPECT_TRUE(points.positions.isApprox(snapshot.objects[0].pose * mesh->vertices));
    snapshot.objects[0].properties.sampling = haptics::Sampling::VERTICES;
    snapshot.objects[0].meshId = 7;
    EXPECT_EQ(assembler->assemble(snapshot).points.size(), 2);
}

TEST_F(Assembler, AModelInOtherUnitsIsAskedAboutOnce)
{
    SceneSnapshot snapshot = facing();
    snapshot.objects[0].path = "Scene/tower";
    auto mesh = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
    mesh->vertices *= 20.0 / mesh->extent().maxCoeff();
    snapshot.objects[0].mesh = mesh;
    snapshot.metresPerUnit = 0.5;
    assembler->assemble(snapshot);
    assembler->assemble(snapshot);
    const auto asked = [&](const std::string& m) { return m.find("metresPerUnit") != m.npos; };
    const std::vector<std::string> said = messages.all();
    ASSERT_EQ(std::count_if(said.begin(), said.end(), asked), 1);
    const std::string wanted = fmt::format(
        "Scene/tower: is 20 m wide, the array {:.3g} m: should metresPerUnit be 0.001 "
        "(millimetres), not 0.5?",
        (array.positions.rowwise().maxCoeff() - array.positions.rowwise().minCoeff()).maxCoeff());
    EXPECT_EQ(*std::find_if(said.begin(), said.end(), asked), wanted);
}

// What fits has a size of 0.2 m.
TEST_F(Assembler, TheUnitThatIsAskedForIsOneThatModelsAreMadeIn)
{
    std::uint64_t id = 100;
    const auto unitOf = [&](double units, double metresPerUnit)
    {
        SceneSnapshot snapshot = facing();
        auto mesh = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
        mesh->vertices *= units * metresPerUnit / mesh->extent().maxCoeff();
        snapshot.objects[0].mesh = mesh;
        snapshot.objects[0].id = snapshot.objects[0].meshId = ++id;
        snapshot.metresPerUnit = metresPerUnit;
        assembler->assemble(snapshot);
        std::string said;
        for (const std::string& one : messages.all())
            if (one.find("m wide, the array") != one.npos) said = one;
        const std::size_t found = said.find("be ");
        if (found == said.npos) return said.substr(said.find_last_of('m') + 1);
        // Only a model that doesn't fit in that unit needs a size as well.
        EXPECT_EQ(said.find("size=") != said.npos, units * std::stod(said.substr(found + 3)) > 0.2)
            << said;
        return said.substr(found + 3, said.find(", not") - found - 3);
    };
    for (const double millimetres : {25.0, 30.0, 80.0, 120.0, 300.0, 2000.0})
        EXPECT_EQ(unitOf(millimetres, 1.0), "0.001 (millimetres)") << millimetres;
    for (const double centimetres : {6.0, 8.0, 15.0})
        EXPECT_EQ(unitOf(centimetres, 1.0), "0.01 (centimetres)") << centimetres;
    EXPECT_EQ(unitOf(2000.0, 0.01), "0.001 (millimetres)");
    // It is in millimetres already, and just large.
    EXPECT_EQ(unitOf(20000.0, 0.001), "; size=0.08 fits");
}

TEST_F(Assembler, WhatIsLargerThanTheWorkspaceIsToldAsThatAlone)
{
    SceneSnapshot snapshot = facing();
    snapshot.objects[0].path = "Scene/wall";
    auto mesh = std::make_shared<haptics::TriangleMesh>(*snapshot.objects[0].mesh);
    mesh->vertices *= 0.8 / mesh->extent().maxCoeff();
    snapshot.objects[0].mesh = mesh;
    for (int frame = 0; frame < 3; ++frame)
    {
        snapshot.objects[0].pose.translation().x() = 0.01 * frame;
        EXPECT_GT(assembler->assemble(snapshot).overBudget, 0u);
    }
    ASSERT_EQ(messages.messages().size(), 1u) << messages.all()[1];
    const haptics::ArrayFront front(array.positions, array.normals);
    const base::Message told = messages.messages()[0];
    EXPECT_EQ(told.code, base::MessageCode::OBJECT_LARGE);
    EXPECT_EQ(told.count, 1u);
    EXPECT_EQ(told.text,
              fmt::format("Scene/wall: is 0.8 m wide, larger than the workspace of {:.2g} m; "
                          "size=0.08 fits",
                          haptics::roomInside_m(assembler->workspace(), front)));
}

TEST_F(Assembler, APartThatGoesOutAndInSaysNothingOfTheWhole)
{
    SceneSnapshot clock = facing();
    clock.objects[0].whole = clock.objects[0].id;
    clock.objects.push_back(clock.objects[0]); // its hand
    clock.objects[1].id = 2;
    for (int turn = 0; turn < 15; ++turn)
        for (const double z : {-0.15, 0.15, 30.0, 0.15})
        {
            clock.objects[1].pose.translation().z() = z;
            EXPECT_GT(assembler->assemble(clock).points.size(), 0);
        }
    ASSERT_EQ(messages.messages().size(), 1u) << messages.all()[1];
    EXPECT_EQ(messages.messages()[0].count, 1u);
    EXPECT_EQ(messages.all()[0],
              "Scene/Square: a part of it that moves is out of the array's reach; it can't be felt "
              "there");
}

TEST_F(Assembler, AStateIsToldWhenItBeginsAndNotInEachFrame)
{
    SceneSnapshot snapshot = facing();
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[1].path = "Scene/Ball";
    const auto framesAt = [&](double z)
    {
        for (int frame = 0; frame < 10; ++frame)
        {
            snapshot.objects[1].pose.translation() = Eigen::Vector3d(0.001 * frame, 0.0, z);
            assembler->assemble(snapshot);
        }
    };
    framesAt(-0.15);
    ASSERT_EQ(messages.messages().size(), 1u);
    EXPECT_EQ(messages.messages()[0].path, "Scene/Ball");
    EXPECT_EQ(messages.messages()[0].count, 1u);
    framesAt(0.2);
    framesAt(-0.15);
    EXPECT_EQ(messages.messages().size(), 1u);
    EXPECT_EQ(messages.messages()[0].count, 2u) << "it had been felt meanwhile";
}

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

// Nearer alone it would still not fit.
TEST_F(Assembler, WhatIsFarAndLargeIsToldOnceWithASizeThatFits)
{
    SceneSnapshot far = facing();
    const haptics::TriangleMesh& mesh = *far.objects[0].mesh;
    far = withVertices(mesh.vertices * (1.0 / mesh.extent().maxCoeff()), 77);
    far.objects[0].pose.translation().z() = 30.0;
    assembler->assemble(far);
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_EQ(messages.messages()[0].code, base::MessageCode::OBJECT_UNREACHABLE);
    const std::string text = messages.all()[0];
    const std::size_t size = text.find("size=");
    ASSERT_NE(size, std::string::npos) << text;
    EXPECT_LT(std::stod(text.substr(size + 5)), 0.5) << text;
}

// A hundred of them would push everything else out of the log.
TEST_F(Assembler, ManyOutOfReachAreOneMessage)
{
    SceneSnapshot far = facing();
    far.objects[0].pose.translation().z() = 30.0;
    for (int i = 1; i < 100; ++i)
    {
        far.objects.push_back(far.objects[0]);
        far.objects.back().id += static_cast<std::uint64_t>(i);
        far.objects.back().path = "Scene/Square " + std::to_string(i);
    }
    assembler->assemble(far);
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_NE(messages.all()[0].find(" 99 more"), std::string::npos) << messages.all()[0];
    EXPECT_EQ(messages.messages()[0].path, "Scene/Square");
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

// The scene's other objects are no reason, and aren't counted.
TEST_F(Assembler, WhyAnObjectIsNotFeltCountsItsOwnPoints)
{
    SceneSnapshot snapshot = facing();
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[0].properties.priority = 1;
    snapshot.objects[1].id = 2;
    snapshot.objects[1].path = "Scene/Under";
    snapshot.objects[1].mesh = squareMesh(0.02);
    snapshot.objects[1].meshId = snapshot.objects[0].meshId + 1;
    const AssembledPoints out = assembler->assemble(snapshot);
    ASSERT_EQ(out.objects[0].leftOut.total(), 0);
    const int own = out.objects[1].leftOut.crowded;
    ASSERT_GT(own, 0);
    ASSERT_GT(out.points.size(), 0);
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_EQ(
        messages.all()[0],
        fmt::format("Scene/Under: none of its points can be felt where it is (0 of {} points: "
                    "{} too near another point)",
                    own,
                    own));
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

TEST_F(Assembler, PlacesKeepTheirIdentity)
{
    using Identities = std::vector<std::uint64_t>;
    const Eigen::Matrix3Xd rest = squareMesh()->vertices;
    SceneSnapshot snapshot = withVertices(rest, 10);
    const Identities first = assembler->assemble(snapshot).points.identity;
    ASSERT_GT(first.size(), 15u);
    EXPECT_EQ(std::set<std::uint64_t>(first.begin(), first.end()).size(), first.size());

    snapshot.objects[0].pose.translation().x() += 0.01;
    EXPECT_EQ(assembler->assemble(snapshot).points.identity, first) << "moved";
    EXPECT_EQ(assembler->assemble(withVertices(1.1 * rest, 11)).points.identity, first) << "bent";

    // Another object, on top of a part of it: what is left of both has its identity.
    snapshot.objects.push_back(snapshot.objects[0]);
    snapshot.objects[1].id = 2;
    snapshot.objects[1].properties.priority = 1;
    snapshot.objects[1].pose.translation().x() += 0.02;
    const Identities both = assembler->assemble(snapshot).points.identity;
    const auto ofFirst = std::count_if(both.begin(),
                                       both.end(),
                                       [&](std::uint64_t one)
                                       { return std::count(first.begin(), first.end(), one) > 0; });
    EXPECT_GT(ofFirst, 0);
    EXPECT_LT(ofFirst, static_cast<std::ptrdiff_t>(first.size()));
    EXPECT_GE(both.size() - static_cast<std::size_t>(ofFirst), first.size()) << "the other one's";

    // Sampled again, they are other places.
    EXPECT_NE(assembler->assemble(withVertices(2.0 * rest, 12)).points.identity[0], first[0]);
}

TEST_F(Assembler, TwoMeshesInTurnAreSampledOnceEach)
{
    const Eigen::Matrix3Xd rest = squareMesh()->vertices;
    for (int turn = 0; turn < 5; ++turn)
        for (const std::uint64_t mesh : {20u, 30u})
            for (int frame = 0; frame < 300; ++frame)
            {
                SceneSnapshot snapshot =
                    withVertices(0.05 * static_cast<double>(mesh) * rest, mesh);
                snapshot.objects[0].topologyId = mesh;
                snapshot.objects[0].pose.translation().x() = 1e-4 * frame;
                assembler->assemble(snapshot);
            }
    EXPECT_EQ(assembler->sampled(), 2u);
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

TEST_F(Assembler, TellsOfPropertiesWithoutEffect)
{
    SceneSnapshot snapshot = facing();
    HapticProperties& properties = snapshot.objects[0].properties;
    const auto told = [&]
    {
        assembler->assemble(snapshot);
        for (const midair::base::Message& one : messages.messages())
            if (one.code == midair::base::MessageCode::PROPERTY_INVALID && one.isActive)
                return one.text;
        return std::string();
    };
    EXPECT_EQ(told(), "");
    properties.material.stiffness_N_m = 50.0;
    EXPECT_NE(told().find("Scene/Square: its material"), std::string::npos) << told();
    properties.render = Render::AUTO; // both count
    properties.pressure = 2.0;
    EXPECT_EQ(told(), "");
    properties.render = Render::CONTACT;
    EXPECT_NE(told().find("Scene/Square: its pressure"), std::string::npos) << told();
    properties.pressure = 1.0;
    EXPECT_EQ(told(), "");
}
