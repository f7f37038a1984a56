#include "engine-bridge/scene/MeshCache.h"

#include "tests/engine-bridge/scene/ExtractedMesh.h"
#include "tests/engine-bridge/scene/OsgScenes.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::bridge;

namespace
{

struct MeshCacheTest : testing::Test
{
    /// The part that moves with the root.
    CachedMesh frame(osg::Node& root, double scale = 1.0)
    {
        const std::vector<CachedMesh> all = parts(root, scale);
        return all.empty() ? CachedMesh() : all.front();
    }

    std::vector<CachedMesh> parts(osg::Node& root, double scale = 1.0)
    {
        std::vector<CachedMesh> out;
        cache.beginFrame();
        cache.get(root, scaled(scale), options, out, warnings);
        cache.endFrame();
        return out;
    }

    static Eigen::Matrix4d scaled(double scale)
    {
        Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
        matrix.topLeftCorner<3, 3>() *= scale;
        return matrix;
    }

    ExtractOptions options;

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
    std::vector<CachedMesh> a;
    std::vector<CachedMesh> b;
    std::vector<CachedMesh> c;
    cache.beginFrame();
    cache.get(*geometry, scaled(1.0), options, a, warnings);
    cache.get(*geometry, scaled(1.0), options, b, warnings);
    cache.get(*geometry, scaled(3.0), options, c, warnings);
    EXPECT_EQ(a[0].mesh, b[0].mesh);
    EXPECT_NE(a[0].meshId, c[0].meshId);
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
        meshes.push_back(frame(*geometry, 1.0 + 0.01 * i).mesh.get());
    int alive = 0;
    for (const auto& mesh : meshes)
        if (!mesh.expired()) ++alive;
    EXPECT_LE(alive, 8);
}

namespace
{

/// Vertices in the array frame, part after part.
Eigen::Matrix3Xd placed(const std::vector<CachedMesh>& parts)
{
    Eigen::Matrix3Xd all(3, 0);
    for (const CachedMesh& part : parts)
    {
        const Eigen::Index n = all.cols();
        all.conservativeResize(3, n + part.mesh->vertices.cols());
        all.rightCols(part.mesh->vertices.cols()) = part.pose * part.mesh->vertices;
    }
    return all;
}

/// A base with an arm, which carries a hand.
struct Robot
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    osg::ref_ptr<osg::MatrixTransform> arm =
        moved(osg::Matrixd::translate(1.0, 0.0, 0.0), triangleGeometry());
    osg::ref_ptr<osg::Geometry> handShape = triangleGeometry();
    osg::ref_ptr<osg::MatrixTransform> hand =
        moved(osg::Matrixd::rotate(0.5, osg::Vec3d(0.0, 0.0, 1.0)), handShape);

    Robot()
    {
        root->addChild(triangleGeometry());
        root->addChild(arm);
        arm->addChild(hand);
    }

    void turn(double arm_rad, double hand_rad)
    {
        arm->setMatrix(osg::Matrixd::rotate(arm_rad, osg::Vec3d(0.0, 1.0, 0.0)) *
                       osg::Matrixd::translate(1.0, 0.0, 0.0));
        hand->setMatrix(osg::Matrixd::rotate(hand_rad, osg::Vec3d(0.0, 0.0, 1.0)));
    }

    /// Everything baked into one mesh: how it is without parts.
    Eigen::Matrix3Xd baked(double scale) const
    {
        return scale * extractMesh(*root).mesh().vertices;
    }
};

} // namespace

TEST_F(MeshCacheTest, AMovingInnerTransformIsReadOnceMoreAndThenOnlyPosed)
{
    Robot robot;
    EXPECT_EQ(parts(*robot.root, 2.0).size(), 1u) << "nothing moves: one mesh";
    robot.turn(0.1, 0.6);
    std::vector<CachedMesh> before = parts(*robot.root, 2.0);
    ASSERT_EQ(before.size(), 3u);
    EXPECT_EQ(cache.extractions(), 2u);
    for (int i = 2; i < 20; ++i)
    {
        robot.turn(0.1 * i, 0.6 + 0.2 * i);
        const std::vector<CachedMesh> now = parts(*robot.root, 2.0);
        ASSERT_EQ(now.size(), 3u);
        for (std::size_t k = 0; k < 3; ++k)
        {
            EXPECT_EQ(now[k].meshId, before[k].meshId);
            EXPECT_EQ(now[k].part, before[k].part);
        }
        EXPECT_LT((placed(now) - robot.baked(2.0)).norm(), 1e-12);
    }
    EXPECT_EQ(cache.extractions(), 2u);
    EXPECT_TRUE(warnings.empty());
}

TEST_F(MeshCacheTest, OnlyThePartWhoseVerticesChangedIsAnotherMesh)
{
    Robot robot;
    parts(*robot.root);
    robot.turn(0.1, 0.6);
    const std::vector<CachedMesh> before = parts(*robot.root);
    ASSERT_EQ(before.size(), 3u);
    (*static_cast<osg::Vec3Array*>(robot.handShape->getVertexArray()))[0].z() = 0.5f;
    robot.handShape->getVertexArray()->dirty();
    const std::vector<CachedMesh> after = parts(*robot.root);
    ASSERT_EQ(after.size(), 3u);
    EXPECT_EQ(after[0].meshId, before[0].meshId);
    EXPECT_EQ(after[1].meshId, before[1].meshId);
    EXPECT_NE(after[2].meshId, before[2].meshId);
    EXPECT_EQ(after[2].topologyId, before[2].topologyId);
    EXPECT_LT((placed(after) - robot.baked(1.0)).norm(), 1e-12);
}

TEST_F(MeshCacheTest, AMoverSharedByTwoParentsIsTwoParts)
{
    auto wheel = moved(osg::Matrixd(), triangleGeometry());
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(moved(osg::Matrixd::translate(-1.0, 0.0, 0.0), wheel));
    root->addChild(moved(osg::Matrixd::translate(1.0, 0.0, 0.0), wheel));
    parts(*root);
    wheel->setMatrix(osg::Matrixd::rotate(0.3, osg::Vec3d(1.0, 0.0, 0.0)));
    const std::vector<CachedMesh> now = parts(*root);
    ASSERT_EQ(now.size(), 2u);
    EXPECT_NE(now[0].part, now[1].part);
    EXPECT_LT((placed(now) - extractMesh(*root).mesh().vertices).norm(), 1e-12);
}

TEST_F(MeshCacheTest, ASingularInnerMatrixTakesOnlyItsPartAway)
{
    Robot robot;
    parts(*robot.root);
    robot.turn(0.1, 0.6);
    EXPECT_EQ(parts(*robot.root).size(), 3u);
    robot.hand->setMatrix(osg::Matrixd::scale(0.0, 0.0, 0.0));
    EXPECT_EQ(parts(*robot.root).size(), 2u);
    EXPECT_EQ(warnings.size(), 1u);
    robot.turn(0.1, 0.6);
    EXPECT_EQ(parts(*robot.root).size(), 3u);
}

namespace
{

/// Six times the signed volume inside \a mesh: over 0 if its faces look outwards.
double volumeOf(const midair::haptics::TriangleMesh& mesh)
{
    double sum = 0.0;
    for (const auto& t : mesh.triangles.colwise())
        sum += mesh.vertices.col(t[0]).dot(mesh.vertices.col(t[1]).cross(mesh.vertices.col(t[2])));
    return sum;
}

} // namespace

TEST_F(MeshCacheTest, AMirrorImageLooksOutwards)
{
    const osg::ref_ptr<osg::Geometry> corner = cornerGeometry();
    const double volume = volumeOf(*frame(*corner).mesh);
    ASSERT_GT(volume, 0.0);
    std::vector<CachedMesh> mirrored;
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix(0, 0) = -1.0; // and not the other two axes
    cache.beginFrame();
    ASSERT_TRUE(cache.get(*corner, matrix, options, mirrored, warnings));
    ASSERT_EQ(mirrored.size(), 1u);
    EXPECT_NEAR(volumeOf(*mirrored[0].mesh), volume, 1e-9);
    EXPECT_NE(mirrored[0].topologyId, frame(*corner).topologyId)
        << "samples can't follow from one to the other";

    const osg::ref_ptr<osg::Group> inner = new osg::Group;
    inner->addChild(moved(osg::Matrixd::scale(1.0, -2.0, 1.0), corner));
    EXPECT_NEAR(volumeOf(*frame(*inner).mesh), 2.0 * volume, 1e-9) << "a transform inside it";
    const osg::ref_ptr<osg::Group> twice = new osg::Group;
    twice->addChild(moved(osg::Matrixd::scale(1.0, -1.0, 1.0), corner));
    cache.beginFrame();
    ASSERT_TRUE(cache.get(*twice, matrix, options, mirrored, warnings));
    EXPECT_NEAR(volumeOf(*mirrored[0].mesh), volume, 1e-9) << "a mirror image of one";
}

TEST_F(MeshCacheTest, APartThatTurnsIntoItsMirrorImageLooksOutwards)
{
    const osg::ref_ptr<osg::MatrixTransform> flip =
        moved(osg::Matrixd::scale(1.0, 1.0, 1.0), cornerGeometry());
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(flip);
    const double volume = volumeOf(*frame(*root).mesh);
    for (const double x : {0.9, -0.9, -1.0, 1.0})
    {
        flip->setMatrix(osg::Matrixd::scale(x, 1.0, 1.0));
        const std::vector<CachedMesh> all = parts(*root);
        ASSERT_EQ(all.size(), 1u);
        EXPECT_NEAR(volumeOf(*all[0].mesh), std::abs(x) * volume, 1e-9) << x;
    }
}
