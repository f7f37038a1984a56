#include "engine-bridge/scene/MeshCache.h"
#include "engine-bridge/scene/SubtreeReading.h"
#include "tests/engine-bridge/scene/OsgScenes.h"

#include <gtest/gtest.h>

using namespace midair::bridge;

namespace
{

struct Vertices : testing::Test
{
    CachedMesh frame()
    {
        std::vector<CachedMesh> out;
        cache.beginFrame();
        cache.get(*root, Eigen::Matrix4d::Identity(), {}, out, warnings);
        cache.endFrame();
        return out.at(0);
    }

    osg::Vec3Array& vertices() { return static_cast<osg::Vec3Array&>(*geometry->getVertexArray()); }

    MeshCache cache;
    std::vector<std::string> warnings;
    osg::ref_ptr<osg::Geometry> geometry = triangleGeometry();
    osg::ref_ptr<osg::Group> root = moved(osg::Matrixd(), // part of the pose
                                          moved(osg::Matrixd::scale(2.0, 2.0, 2.0), geometry));
};

} // namespace

TEST_F(Vertices, ThoseChangedWithoutDirtyAreSeen)
{
    const CachedMesh before = frame();
    vertices()[1].x() = 3.0f;
    const CachedMesh after = frame();
    EXPECT_NE(after.meshId, before.meshId);
    EXPECT_EQ(after.topologyId, before.topologyId);
    EXPECT_EQ(after.mesh->vertices(0, 1), 6.0);
    EXPECT_EQ(before.mesh->vertices(0, 1), 2.0);
    EXPECT_EQ(frame().meshId, after.meshId);
}

TEST_F(Vertices, OfALargeArrayOneThatChangedIsSeenAfterAsManyFramesAsItHasParts)
{
    vertices().resize(5 * VertexCopy::kAtOnce - 7);
    vertices().dirty();
    std::uint64_t id = frame().meshId;
    for (const std::size_t changed : {std::size_t(0), std::size_t(9000), vertices().size() - 1})
    {
        vertices()[changed].z() += 1.0f;
        int frames = 1;
        while (frame().meshId == id && frames < 20)
            ++frames;
        EXPECT_LE(frames, 5) << changed;
        id = frame().meshId;
    }
    // Where a fifth of all change, it is seen at once.
    for (std::size_t i = 4000; i < 8096; ++i)
        vertices()[i].z() += 1.0f;
    EXPECT_NE(frame().meshId, id);
}

TEST_F(Vertices, ANewerMeshIsThatOfItsOwnFrame)
{
    frame();
    vertices()[2].y() = 5.0f;
    vertices().dirty();
    const CachedMesh first = frame();
    vertices()[2].y() = 7.0f; // before anyone has looked at the first mesh
    vertices().dirty();
    const CachedMesh second = frame();
    EXPECT_EQ(first.mesh->vertices(1, 2), 10.0);
    EXPECT_EQ(second.mesh->vertices(1, 2), 14.0);
    EXPECT_EQ(second.mesh->triangles, first.mesh->triangles);
}

TEST_F(Vertices, AnotherArrayOfTheSameSizeIsFollowed)
{
    const CachedMesh before = frame();
    osg::ref_ptr<osg::Vec3dArray> other = new osg::Vec3dArray(3);
    (*other)[1] = osg::Vec3d(0.25, 0.0, 0.0);
    geometry->setVertexArray(other);
    const CachedMesh after = frame();
    EXPECT_EQ(after.topologyId, before.topologyId);
    EXPECT_EQ(after.mesh->vertices(0, 1), 0.5);
}

TEST_F(Vertices, AnArrayThatGrewOrIsGoneIsReadAnew)
{
    const CachedMesh before = frame();
    vertices().push_back({0.0f, 0.0f, 1.0f});
    EXPECT_NE(frame().topologyId, before.topologyId);
    vertices().clear();
    std::vector<CachedMesh> out;
    cache.beginFrame();
    cache.get(*root, Eigen::Matrix4d::Identity(), {}, out, warnings);
    cache.endFrame();
    EXPECT_TRUE(out.empty());
}
