// Touch of large and deforming meshes: the same as a look at every triangle, on another thread.
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "tests/Eventually.h"
#include "tests/Halt.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;
using Mesh = haptics::TriangleMesh;

/// A sphere of 30 mm, dented by \a depth where \a phase says.
std::shared_ptr<Mesh> dented(int rings, double depth, double phase)
{
    auto mesh = sphere(0.03, rings);
    for (auto corner : mesh->vertices.colwise())
        corner *= 1.0 + depth * std::sin(phase + 200.0 * corner.x() + 150.0 * corner.y());
    return mesh;
}

/// The nearest triangle by a look at every one.
NearestSpot slowNearest(const Mesh& mesh, const Capsule& capsule, double range_m)
{
    NearestSpot best;
    best.distance_m = INFINITY;
    for (int t = 0; t < mesh.triangles.cols(); ++t)
    {
        const Eigen::Vector3i corner = mesh.triangles.col(t);
        if (!isFinite(mesh, t)) continue;
        const ClosestPair pair = closestSegmentTriangle(capsule.a,
                                                        capsule.b,
                                                        mesh.vertices.col(corner[0]),
                                                        mesh.vertices.col(corner[1]),
                                                        mesh.vertices.col(corner[2]));
        const double distance = pair.distance - capsule.radius_m;
        if (distance > range_m || !(distance < best.distance_m)) continue;
        best = {distance, pair.onOther, pair.onSegment, t};
    }
    return best;
}

/// The area by a look at every triangle, each as a mesh of its own.
double slowArea(const Mesh& mesh, const std::vector<Capsule>& capsules)
{
    double area = 0.0;
    for (int t = 0; t < mesh.triangles.cols(); ++t)
    {
        auto one = std::make_shared<Mesh>();
        one->vertices.resize(3, 3);
        one->triangles.resize(3, 1);
        for (int k = 0; k < 3; ++k)
        {
            one->vertices.col(k) = mesh.vertices.col(mesh.triangles(k, t));
            one->triangles(k, 0) = k;
        }
        area += MeshDistance(one).overlapArea(capsules, 2e-3);
    }
    return area;
}

std::vector<Capsule> someCapsules(std::mt19937_64& random)
{
    std::normal_distribution<double> normal;
    const auto any = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
    std::vector<Capsule> capsules;
    for (int k = 0; k < 4; ++k)
    {
        const Vector3d a = 0.033 * any().normalized();
        capsules.push_back({a, a + 0.01 * any(), 0.008});
    }
    return capsules;
}

void expectAsSlow(const MeshDistance& fast, const std::vector<Capsule>& capsules)
{
    const Mesh& mesh = fast.mesh();
    for (const Capsule& capsule : capsules)
    {
        const NearestSpot wanted = slowNearest(mesh, capsule, 0.02);
        const NearestSpot found = fast.nearest(capsule, 0.02);
        EXPECT_EQ(found.triangle, wanted.triangle);
        EXPECT_EQ(found.distance_m, wanted.distance_m);
        EXPECT_EQ(found.onSurface, wanted.onSurface);
    }
    const double area = slowArea(mesh, capsules);
    EXPECT_NEAR(fast.overlapArea(capsules, 2e-3), area, 1e-12 + 1e-9 * area);
}

/// An object of a mesh that counts as large, made by \a make where it is looked at.
HapticObject large(std::uint64_t id, std::uint64_t meshId, std::function<Mesh()> make)
{
    HapticObject object;
    object.id = id;
    object.meshId = meshId;
    object.topologyId = 1;
    object.touchEvents = true;
    object.mesh = SharedMesh::later(std::move(make), TouchMeshes::kAtOnce + 1);
    return object;
}

std::shared_ptr<const MeshDistance> ask(TouchMeshes& meshes, const HapticObject& object)
{
    meshes.beginUpdate();
    auto found = meshes.get(object);
    meshes.endUpdate();
    return found;
}

} // namespace

TEST(MeshDistance, FindsWhatALookAtEveryTriangleFinds)
{
    std::mt19937_64 random(5);
    for (int run = 0; run < 10; ++run)
    {
        const MeshDistance distance(dented(12, 0.1, run));
        expectAsSlow(distance, someCapsules(random));
    }
}

TEST(MeshDistance, FollowsADeformationExactly)
{
    std::mt19937_64 random(6);
    auto before = std::make_unique<MeshDistance>(dented(12, 0.1, 0.0));
    for (int step = 1; step <= 10; ++step)
    {
        auto mesh = dented(12, 0.1, 0.3 * step);
        if (step == 4) mesh->vertices.col(100).setConstant(std::nan("")); // and well again at 5
        if (step == 6) mesh->vertices(1, 120) = std::numeric_limits<double>::infinity();
        if (step == 8) mesh->vertices *= 3.0; // too different for the old order
        auto now = std::make_unique<MeshDistance>(mesh, before.get());
        expectAsSlow(*now, someCapsules(random));
        before = std::move(now);
    }
}

TEST(TouchMeshes, ALargeMeshIsPreparedOnAnotherThread)
{
    const std::thread::id own = std::this_thread::get_id();
    auto madeBy = std::make_shared<std::atomic<std::thread::id>>(own);
    TouchMeshes meshes;
    const HapticObject object = large(7,
                                      1,
                                      [madeBy]
                                      {
                                          *madeBy = std::this_thread::get_id();
                                          return *sphere(0.03, 40);
                                      });
    std::shared_ptr<const MeshDistance> found = ask(meshes, object);
    EXPECT_EQ(found, nullptr) << "not yet, and nobody waits";
    ASSERT_TRUE(eventually([&] { return (found = ask(meshes, object)) != nullptr; }));
    EXPECT_NE(madeBy->load(), own);
    EXPECT_EQ(ask(meshes, object), found) << "the same while the mesh is";
    HapticObject twin = object;
    twin.id = 8;
    EXPECT_EQ(ask(meshes, twin), found) << "objects share a mesh";
}

TEST(TouchMeshes, OfMeshesThatComeFasterThanTheyArePreparedTheNewestCounts)
{
    auto gate = std::make_shared<Halt>(true);
    auto began = std::make_shared<std::atomic<bool>>(false);
    auto made = std::make_shared<std::atomic<int>>(0);
    const auto mesh = [=](std::uint64_t meshId)
    {
        return large(7,
                     meshId,
                     [=]
                     {
                         *began = true;
                         gate->pass();
                         ++*made;
                         return *dented(20, 0.1, static_cast<double>(meshId));
                     });
    };
    TouchMeshes meshes;
    ask(meshes, mesh(1));
    ASSERT_TRUE(eventually([&] { return began->load(); }));
    for (std::uint64_t meshId = 2; meshId < 100; ++meshId)
        EXPECT_EQ(ask(meshes, mesh(meshId)), nullptr);
    const HapticObject newest = mesh(100);
    ask(meshes, newest);
    *gate = false;
    const Mesh wanted = *dented(20, 0.1, 100.0);
    ASSERT_TRUE(eventually(
        [&]
        {
            const auto found = ask(meshes, newest);
            return found && found->mesh().vertices == wanted.vertices;
        }));
    EXPECT_EQ(*made, 2) << "the first and the newest";
}

TEST(TouchMeshes, WhileTheNextIsPreparedTheLastOneServes)
{
    TouchMeshes meshes;
    const HapticObject first = large(7, 1, [] { return *sphere(0.03, 20); });
    std::shared_ptr<const MeshDistance> found;
    ASSERT_TRUE(eventually([&] { return (found = ask(meshes, first)) != nullptr; }));
    auto gate = std::make_shared<Halt>(true);
    const HapticObject next = large(7,
                                    2,
                                    [gate]
                                    {
                                        gate->pass();
                                        return *dented(20, 0.1, 0.0);
                                    });
    for (int k = 0; k < 5; ++k)
        EXPECT_EQ(ask(meshes, next), found);
    *gate = false;
    EXPECT_TRUE(eventually([&] { return ask(meshes, next) != found; }));
}

TEST(HandProximity, ALargeMeshIsTouchedAsSoonAsItIsPrepared)
{
    const auto mesh = sphere(0.03, 60);
    const HapticObject object = large(7, 1, [mesh] { return *mesh; });
    HandFrame hands;
    hands.hands.push_back(
        openHandWithIndexTipAt(1, Vector3d(0.0, 0.0, 0.035), Eigen::Quaterniond::Identity()));
    HandProximity proximity;
    double time_s = 0.0;
    ASSERT_TRUE(eventually(
        [&]
        {
            proximity.update({object}, hands, time_s += 0.01);
            return !proximity.contacts().empty();
        }));
    for (const HandContact& contact : proximity.contacts())
    {
        double wanted = INFINITY;
        for (const HandCapsule& capsule : handCapsules(hands))
            if (fingerOf(capsule.bone) == contact.finger)
                wanted = std::min(wanted, slowNearest(*mesh, capsule.shape, 0.05).distance_m);
        EXPECT_EQ(contact.distance_m, wanted);
    }
}

} // namespace midair::bridge
