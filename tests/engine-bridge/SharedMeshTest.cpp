#include "engine-bridge/SharedMesh.h"

#include <memory>

#include <gtest/gtest.h>

using midair::bridge::SharedMesh;
using midair::haptics::TriangleMesh;

TEST(SharedMesh, IsMadeOnceAndByWhoeverLooksFirst)
{
    int made = 0;
    const auto kept = std::make_shared<int>(0);
    SharedMesh mesh = SharedMesh::later(
        [&made, kept]
        {
            ++made;
            TriangleMesh result;
            result.vertices.setZero(3, 5);
            return result;
        },
        77);
    const SharedMesh copy = mesh;
    EXPECT_TRUE(mesh && mesh == copy);
    EXPECT_EQ(made, 0);
    EXPECT_EQ(copy.bytes(), 77u) << "known before it is made";
    EXPECT_EQ(copy->vertices.cols(), 5);
    EXPECT_EQ(&*mesh, &*copy);
    EXPECT_EQ(made, 1);
    EXPECT_EQ(kept.use_count(), 1) << "what it is made of is let go of";
    EXPECT_EQ(mesh.useCount(), 2);
}

TEST(SharedMesh, OneThatNobodyLooksAtIsNotMade)
{
    bool made = false;
    SharedMesh mesh = SharedMesh::later(
        [&made]
        {
            made = true;
            return TriangleMesh();
        },
        77);
    mesh = nullptr;
    EXPECT_FALSE(mesh);
    EXPECT_EQ(mesh.get(), nullptr);
    EXPECT_FALSE(made);
}

TEST(SharedMesh, ANullPointerIsNoMesh)
{
    EXPECT_FALSE(SharedMesh(std::shared_ptr<TriangleMesh>()));
    const auto there = std::make_shared<const TriangleMesh>();
    EXPECT_EQ(SharedMesh(there).get(), there);
}
