// Large subtrees are copied in slices and made meshes by whoever looks at them.

#include "engine-bridge/scene/MeshCache.h"
#include "tests/engine-bridge/scene/ExtractedMesh.h"
#include "tests/engine-bridge/scene/OsgScenes.h"

#include <thread>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// A strip of triangles (i, i + 1, i + 2) over \a count vertices: 24 bytes a vertex.
osg::ref_ptr<osg::Geometry> strip(unsigned int count)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::DrawElementsUInt> triangles = new osg::DrawElementsUInt(GL_TRIANGLES);
    for (unsigned int i = 0; i < count; ++i)
        vertices->push_back(osg::Vec3(static_cast<float>(i), i % 2 == 0 ? 0.0f : 1.0f, 0.0f));
    for (unsigned int i = 0; i + 2 < count; ++i)
        for (const unsigned int k : {0U, 1U, 2U})
            triangles->push_back(i + k);
    geometry->setVertexArray(vertices);
    geometry->addPrimitiveSet(triangles);
    return geometry;
}

struct Reading : testing::Test
{
    std::vector<CachedMesh> frame(osg::Node& root)
    {
        std::vector<CachedMesh> out;
        cache.beginFrame();
        cache.get(root, Eigen::Matrix4d::Identity(), options, out, warnings);
        cache.endFrame();
        return out;
    }

    /// Frames until all of \a root is read.
    int framesToRead(osg::Node& root)
    {
        int frames = 1;
        for (frame(root); cache.isBeingRead(root) && frames < 100; frame(root))
            ++frames;
        return frames;
    }

    static osg::Vec3Array& verticesOf(osg::Geometry& geometry)
    {
        return static_cast<osg::Vec3Array&>(*geometry.getVertexArray());
    }

    ExtractOptions options;
    MeshCache cache;
    std::vector<std::string> warnings;
};

/// Copying it takes five frames and a bit.
constexpr unsigned int kMany = 5 * MeshCache::kFrameBytes / 24 + 1000;

} // namespace

TEST_F(Reading, ASmallMeshIsThereAtOnce)
{
    const auto small = strip(2000);
    const auto parts = frame(*small);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_FALSE(cache.isBeingRead(*small));
    EXPECT_EQ(parts[0].mesh->triangles.cols(), 1998);
}

TEST_F(Reading, ALargeMeshComesWholeAndNoFrameCopiesMoreThanItsShare)
{
    const auto large = strip(kMany);
    for (int i = 0; i < 5; ++i)
    {
        EXPECT_TRUE(frame(*large).empty()) << "never a part of it";
        EXPECT_TRUE(cache.isBeingRead(*large));
    }
    EXPECT_EQ(cache.extractions(), 0u);
    const auto parts = frame(*large);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_FALSE(cache.isBeingRead(*large));
    EXPECT_EQ(cache.extractions(), 1u);
    const haptics::TriangleMesh expected = extractMesh(*large).mesh();
    EXPECT_EQ(parts[0].mesh->vertices, expected.vertices);
    EXPECT_EQ(parts[0].mesh->triangles, expected.triangles);
    EXPECT_EQ(frame(*large).at(0).meshId, parts[0].meshId);
}

TEST_F(Reading, WhatIsCopiedIsNoLongerTheApplications)
{
    osg::ref_ptr<osg::Geometry> large = strip(kMany);
    options.paint.source = PaintOptions::VERTEX_COLORS;
    osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array(osg::Array::BIND_PER_VERTEX, kMany);
    std::fill(colors->begin(), colors->end(), osg::Vec4(0.5f, 0.5f, 0.5f, 1.0f));
    large->setColorArray(colors);
    framesToRead(*large);
    const SharedMesh mesh = frame(*large).at(0).mesh;
    verticesOf(*large).assign(kMany, osg::Vec3(9.0f, 9.0f, 9.0f));
    verticesOf(*large).clear();
    large->removePrimitiveSet(0);
    colors->clear();
    std::thread([&] { mesh.get(); }).join();
    EXPECT_EQ(mesh->triangles.cols(), Eigen::Index(kMany - 2));
    EXPECT_EQ(mesh->vertices(0, kMany - 1), kMany - 1);
    EXPECT_EQ(mesh->intensity[kMany - 1], 0.5f);
}

TEST_F(Reading, VerticesThatMoveMeanwhileAreThoseOfTheFrameThatReadTheLast)
{
    const auto large = strip(kMany);
    std::vector<CachedMesh> parts;
    for (int i = 0; i < 100 && parts.empty(); ++i)
    {
        for (osg::Vec3& vertex : verticesOf(*large))
            vertex.z() = static_cast<float>(i);
        verticesOf(*large).dirty();
        parts = frame(*large);
        if (parts.empty()) continue;
        EXPECT_TRUE((parts[0].mesh->vertices.row(2).array() == i).all()) << "frame " << i;
        EXPECT_LT(i, 10);
    }
    EXPECT_FALSE(parts.empty());
}

TEST_F(Reading, TheFormerMeshStaysUntilTheNewOneIsWhole)
{
    const auto large = strip(kMany);
    framesToRead(*large);
    const std::uint64_t before = frame(*large).at(0).meshId;
    large->getPrimitiveSet(0)->dirty();
    for (int i = 0; i < 5; ++i)
    {
        EXPECT_EQ(frame(*large).at(0).meshId, before);
        EXPECT_TRUE(cache.isBeingRead(*large));
    }
    EXPECT_NE(frame(*large).at(0).meshId, before);
    EXPECT_FALSE(cache.isBeingRead(*large));
}

TEST_F(Reading, WhatChangesItsTrianglesAllTheTimeIsReadAllTheSame)
{
    const auto large = strip(kMany);
    int read = 0;
    for (int i = 0; i < 30; ++i)
    {
        large->getPrimitiveSet(0)->dirty();
        frame(*large);
        if (!cache.isBeingRead(*large)) ++read;
    }
    EXPECT_GT(read, 20);
}

TEST_F(Reading, SeveralShareAFrameAndNoneStarves)
{
    std::vector<osg::ref_ptr<osg::Geometry>> all;
    for (int i = 0; i < 10; ++i)
        all.push_back(strip(MeshCache::kFrameBytes / 48)); // half a frame's bytes
    int frames = 0;
    for (std::size_t whole = 0; whole < all.size() && frames < 100; ++frames)
    {
        whole = 0;
        cache.beginFrame();
        for (const auto& one : all)
        {
            std::vector<CachedMesh> out;
            cache.get(*one, Eigen::Matrix4d::Identity(), options, out, warnings);
            whole += out.size();
        }
        cache.endFrame();
        EXPECT_TRUE(frames > 0 || whole <= 2) << whole;
    }
    EXPECT_GE(frames, 4);
    EXPECT_LE(frames, 6);
}

TEST_F(Reading, ManySmallOnesUseUpAFramesShare)
{
    std::vector<osg::ref_ptr<osg::Geometry>> all;
    const auto readUntilFull = [&]
    {
        std::size_t count = 0;
        std::vector<CachedMesh> out;
        cache.beginFrame();
        for (const auto& one : all)
            cache.get(*one, Eigen::Matrix4d::Identity(), options, out, warnings);
        for (; !cache.isFull(); ++count)
        {
            all.push_back(strip(100));
            cache.get(*all.back(), Eigen::Matrix4d::Identity(), options, out, warnings);
        }
        cache.endFrame();
        return count;
    };
    constexpr std::size_t kCost = MeshCache::kSubtreeWork + 98 * 12 + 1200 + 24;
    EXPECT_NEAR(readUntilFull(), static_cast<double>(MeshCache::kFrameBytes) / kCost, 1.0);
    for (int i = 0; i < 200; ++i)
        readUntilFull();
    EXPECT_NEAR(readUntilFull(), static_cast<double>(MeshCache::kLeastBytes) / kCost, 1.0)
        << "what is there takes its share, too";
}

TEST_F(Reading, ASmallOneIsNotKeptWaitingByOneLargeButByMany)
{
    cache.beginFrame();
    std::vector<osg::ref_ptr<osg::Geometry>> all;
    for (int i = 0; i < MeshCache::kMostUnfinished; ++i)
    {
        EXPECT_FALSE(cache.isFull()) << i;
        all.push_back(strip(kMany));
        std::vector<CachedMesh> out;
        cache.get(*all.back(), Eigen::Matrix4d::Identity(), options, out, warnings);
    }
    EXPECT_TRUE(cache.isFull());
}

TEST_F(Reading, WhereThereIsMuchWhatChangesWithoutDirtyIsSeenInTurn)
{
    std::vector<osg::ref_ptr<osg::Geometry>> all;
    for (std::size_t bytes = 0; bytes < 3 * MeshCache::kComparedBytes; bytes += 48000)
        all.push_back(strip(2000));
    std::vector<CachedMesh> out;
    const auto idsNow = [&]
    {
        std::vector<std::uint64_t> ids;
        cache.beginFrame();
        for (const auto& one : all)
        {
            cache.get(*one, Eigen::Matrix4d::Identity(), options, out, warnings);
            ids.push_back(out.at(0).meshId);
        }
        cache.endFrame();
        return ids;
    };
    const std::vector<std::uint64_t> before = idsNow();
    for (const auto& one : all)
        verticesOf(*one)[3].z() = 1.0f;
    std::vector<std::uint64_t> after = idsNow();
    EXPECT_NE(after, before);
    EXPECT_EQ(after.back(), before.back()) << "not all in one frame";
    for (int i = 0; i < 6; ++i)
        after = idsNow();
    for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_NE(after[i], before[i]) << i;
}

TEST_F(Reading, WhatIsFoundOutWhereTheMeshIsMadeIsToldOnce)
{
    const auto large = strip(kMany);
    large->setName("broken");
    static_cast<osg::DrawElementsUInt&>(*large->getPrimitiveSet(0))[0] = kMany;
    framesToRead(*large);
    const auto parts = frame(*large);
    EXPECT_TRUE(warnings.empty());
    std::thread([&] { parts.at(0).mesh.get(); }).join();
    for (int i = 0; i < 3; ++i)
        frame(*large);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].find("Geometry 'broken' has indices beyond its"), 0u) << warnings[0];
}

TEST_F(Reading, IndicesChangedWithoutDirtyAreSeen)
{
    const auto geometry = strip(100);
    const CachedMesh before = frame(*geometry).at(0);
    static_cast<osg::DrawElementsUInt&>(*geometry->getPrimitiveSet(0))[5] = 7;
    const CachedMesh after = frame(*geometry).at(0);
    EXPECT_NE(after.topologyId, before.topologyId);
    EXPECT_EQ(after.mesh->triangles(2, 1), 7);
    EXPECT_EQ(frame(*geometry).at(0).meshId, after.meshId);
    geometry->setPrimitiveSet(0, new osg::DrawArrays(GL_TRIANGLES, 0, 6));
    EXPECT_EQ(frame(*geometry).at(0).mesh->triangles.cols(), 2);
    static_cast<osg::DrawArrays&>(*geometry->getPrimitiveSet(0)).setCount(9);
    EXPECT_EQ(frame(*geometry).at(0).mesh->triangles.cols(), 3);
}

TEST_F(Reading, PaintChangedWithoutDirtyIsSeen)
{
    const auto geometry = strip(100);
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray(osg::Array::BIND_PER_VERTEX, 100);
    std::fill(colors->begin(), colors->end(), osg::Vec4ub(255, 255, 255, 255));
    geometry->setColorArray(colors);
    options.paint.source = PaintOptions::VERTEX_COLORS;
    const CachedMesh before = frame(*geometry).at(0);
    EXPECT_EQ(before.mesh->intensity[99], 1.0f);
    (*colors)[99] = osg::Vec4ub(0, 0, 0, 255);
    const CachedMesh after = frame(*geometry).at(0);
    EXPECT_NE(after.meshId, before.meshId);
    EXPECT_EQ(after.mesh->intensity[99], 0.0f);
    EXPECT_EQ(frame(*geometry).at(0).meshId, after.meshId);
}

TEST_F(Reading, OfALargeArrayOfIndicesOneThatChangedIsSeenInTurn)
{
    const auto geometry = strip(5000); // 14,994 indices: four parts
    const std::uint64_t before = frame(*geometry).at(0).topologyId;
    static_cast<osg::DrawElementsUInt&>(*geometry->getPrimitiveSet(0))[14000] = 7;
    int frames = 1;
    while (frame(*geometry).at(0).topologyId == before && frames < 20)
        ++frames;
    EXPECT_LE(frames, 4);
}
