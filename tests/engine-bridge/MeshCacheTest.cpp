#include "engine-bridge/MeshCache.h"

#include "OsgScenes.h"

#include <gtest/gtest.h>

using namespace midair::bridge;

namespace
{

struct MeshCacheTest : testing::Test
{
    CachedMesh frame(osg::Node& root, double scale = 1.0)
    {
        cache.beginFrame();
        CachedMesh mesh = cache.get(root, Eigen::Matrix3d::Identity() * scale, {}, warnings);
        cache.endFrame();
        return mesh;
    }

    MeshCache cache;
    std::vector<std::string> warnings;
    osg::ref_ptr<osg::Geometry> geometry = triangleGeometry();
};

} // namespace

TEST_F(MeshCacheTest, AnUnchangedMeshIsReadOnce)
{
    const CachedMesh first = frame(*geometry);
    const CachedMesh second = frame(*geometry);
    EXPECT_EQ(first.meshId, second.meshId);
    EXPECT_EQ(first.mesh, second.mesh);
    EXPECT_EQ(cache.extractions(), 1u);
}

TEST_F(MeshCacheTest, ScaleIsBakedInAndIsANewMeshOfTheSameTriangles)
{
    const CachedMesh one = frame(*geometry, 1.0);
    const CachedMesh two = frame(*geometry, 2.0);
    EXPECT_NE(one.meshId, two.meshId);
    EXPECT_EQ(one.topologyId, two.topologyId);
    EXPECT_EQ(two.mesh->vertices(0, 1), 2.0);
    EXPECT_EQ(cache.extractions(), 1u);
    EXPECT_EQ(frame(*geometry, 1.0).meshId, one.meshId) << "back at the old size: the old mesh";
}

TEST_F(MeshCacheTest, RoundingOfTheScaleIsNoNewMesh)
{
    EXPECT_EQ(frame(*geometry, 1.0).meshId, frame(*geometry, 1.0 + 1e-9).meshId);
}

TEST_F(MeshCacheTest, TwoInstancesOfOneSizeShareTheMesh)
{
    cache.beginFrame();
    const CachedMesh a = cache.get(*geometry, Eigen::Matrix3d::Identity(), {}, warnings);
    const CachedMesh b = cache.get(*geometry, Eigen::Matrix3d::Identity(), {}, warnings);
    const CachedMesh c = cache.get(*geometry, Eigen::Matrix3d::Identity() * 3.0, {}, warnings);
    EXPECT_EQ(a.mesh, b.mesh);
    EXPECT_NE(a.meshId, c.meshId);
    EXPECT_EQ(cache.extractions(), 1u);
}

TEST_F(MeshCacheTest, AMorphedMeshKeepsItsTopology)
{
    const CachedMesh before = frame(*geometry);
    (*static_cast<osg::Vec3Array*>(geometry->getVertexArray()))[0].z() = 0.5f;
    geometry->getVertexArray()->dirty();
    const CachedMesh after = frame(*geometry);
    EXPECT_NE(after.meshId, before.meshId);
    EXPECT_EQ(after.topologyId, before.topologyId);
    EXPECT_EQ(after.mesh->vertices(2, 0), 0.5);
    EXPECT_EQ(before.mesh->vertices(2, 0), 0.0) << "a mesh once handed out never changes";
}

TEST_F(MeshCacheTest, OtherTrianglesAreAnotherTopology)
{
    const CachedMesh before = frame(*geometry);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
    EXPECT_NE(frame(*geometry).topologyId, before.topologyId);
}

TEST_F(MeshCacheTest, WarnsOncePerShapeNotPerFrame)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    auto absolute = moved(osg::Matrixd(), triangleGeometry());
    absolute->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    root->addChild(absolute);
    frame(*root);
    frame(*root);
    EXPECT_EQ(warnings.size(), 1u);
}

TEST_F(MeshCacheTest, AScalingObjectDoesNotFillTheMemory)
{
    std::vector<std::weak_ptr<const midair::haptics::TriangleMesh>> meshes;
    for (int i = 0; i < 100; ++i)
        meshes.push_back(frame(*geometry, 1.0 + 0.01 * i).mesh);
    int alive = 0;
    for (const auto& mesh : meshes)
        if (!mesh.expired()) ++alive;
    EXPECT_LE(alive, 8);
}
