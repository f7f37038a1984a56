#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"

#include <osg/AutoTransform>
#include <osg/Geometry>
#include <osgAnimation/Bone>
#include <osgAnimation/MorphGeometry>
#include <osgAnimation/RigGeometry>
#include <osgAnimation/RigTransformHardware>
#include <osgAnimation/RigTransformSoftware>
#include <osgAnimation/Skeleton>

#include <algorithm>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

constexpr double kEdge_m = 0.06;
constexpr int kCells = 6;

/// A plate from the origin to (60 mm, 60 mm, 0).
osg::ref_ptr<osg::Geometry> plate()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    for (int j = 0; j <= kCells; ++j)
        for (int i = 0; i <= kCells; ++i)
        {
            vertices->push_back(osg::Vec3d(kEdge_m * i / kCells, kEdge_m * j / kCells, 0.0));
            normals->push_back(osg::Vec3(0.0f, 0.0f, 1.0f));
        }
    osg::ref_ptr<osg::DrawElementsUInt> triangles = new osg::DrawElementsUInt(GL_TRIANGLES);
    for (int j = 0; j < kCells; ++j)
        for (int i = 0; i < kCells; ++i)
        {
            const auto a = static_cast<unsigned int>(j * (kCells + 1) + i);
            const unsigned int b = a + kCells + 1;
            for (const unsigned int index : {a, a + 1, b + 1, a, b + 1, b})
                triangles->push_back(index);
        }
    geometry->setVertexArray(vertices);
    geometry->setNormalArray(normals);
    geometry->addPrimitiveSet(triangles);
    geometry->setName("plate");
    return geometry;
}

/// A haptic node over the board, its child's origin at (0, 0, 0.15).
struct Scene
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    osg::ref_ptr<osg::MatrixTransform> at =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    osg::ref_ptr<HapticSurface> surface = new HapticSurface;

    explicit Scene(osg::Node* child)
    {
        scene->setArray("board");
        scene->addChild(at);
        at->addChild(surface);
        surface->addChild(child);
    }

    std::shared_ptr<const midair::bridge::HologramResult> result() const
    {
        return SceneAccess::latestResult(*scene);
    }

    /// Largest distance in z of a control point from 0.15 + slope * (x or y of the point).
    double offPlane(int axis, double slope) const
    {
        const Eigen::Matrix3Xd& p = result()->points.positions;
        return (p.row(2).array() - 0.15 - slope * p.row(axis).array()).abs().maxCoeff();
    }

    bool says(const std::string& words) const
    {
        const auto messages = scene->getStatistics().messages;
        return std::any_of(messages.begin(),
                           messages.end(),
                           [&](const std::string& m)
                           { return m.find(words) != std::string::npos; });
    }
};

/// A plate on two bones: one holds its edge at y = 0, the other that at y = 60 mm.
struct Rig
{
    osg::ref_ptr<osgAnimation::Skeleton> skeleton = new osgAnimation::Skeleton;
    osg::ref_ptr<osgAnimation::Bone> root = new osgAnimation::Bone("root");
    osg::ref_ptr<osgAnimation::Bone> tip = new osgAnimation::Bone("tip");
    osg::ref_ptr<osgAnimation::RigGeometry> skin = new osgAnimation::RigGeometry;

    explicit Rig(osgAnimation::RigTransform* transform)
    {
        const osg::ref_ptr<osg::Geometry> source = plate();
        const auto& vertices = static_cast<const osg::Vec3Array&>(*source->getVertexArray());
        osg::ref_ptr<osgAnimation::VertexInfluenceMap> map = new osgAnimation::VertexInfluenceMap;
        (*map)["root"].setName("root");
        (*map)["tip"].setName("tip");
        for (unsigned int i = 0; i < vertices.size(); ++i)
        {
            const float share = vertices[i].y() / static_cast<float>(kEdge_m);
            (*map)["root"].emplace_back(i, 1.0f - share);
            (*map)["tip"].emplace_back(i, share);
        }
        skin->setName("skin");
        skin->setInfluenceMap(map);
        skin->setSourceGeometry(source);
        skin->copyFrom(*source);
        skin->setRigTransformImplementation(transform);
        skin->setDataVariance(osg::Object::DYNAMIC);
        skin->addUpdateCallback(new osgAnimation::UpdateRigGeometry);
        root->addChild(tip);
        skeleton->addChild(root);
        skeleton->addChild(skin);
    }

    /// The edge at y = 60 mm up by \a height.
    void lift(double height) const
    {
        tip->setMatrixInSkeletonSpace(osg::Matrixd::translate(0.0, 0.0, height));
    }
};

} // namespace

TEST(Deforming, PointsFollowASoftwareSkin)
{
    Rig rig(new osgAnimation::RigTransformSoftware);
    Scene scene(rig.skeleton);
    HeadlessViewer viewer(scene.scene);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return scene.result() && scene.result()->points.size() > 0; }));
    const std::uint64_t sampled = scene.scene->getStatistics().meshesSampled;
    for (const double height : {0.01, 0.02, 0.03})
    {
        rig.lift(height);
        viewer.frame();
        const unsigned int frame = viewer.viewer.getFrameStamp()->getFrameNumber();
        ASSERT_TRUE(viewer.framesUntil([&] { return scene.result()->frame >= frame; }));
        // Weights along y and a translation: the skinned plate is the plane z = height y/60 mm.
        // Float vertices.
        EXPECT_LT(scene.offPlane(1, height / kEdge_m), 1e-7) << height;
        EXPECT_LT(scene.offPlane(1, 0.0), 1.01 * height);
    }
    EXPECT_EQ(scene.scene->getStatistics().meshesSampled, sampled) << "12 % longer: they follow";
    EXPECT_GE(scene.scene->getStatistics().meshesFollowed, 3u);
    const int before = scene.result()->points.size();
    rig.lift(0.06);
    ASSERT_TRUE(viewer.framesUntil([&] { return scene.result()->points.size() > before; }))
        << "1.41 times as long: sampled again, more points";
    EXPECT_LT(scene.offPlane(1, 1.0), 1e-7);
    EXPECT_EQ(scene.scene->getStatistics().meshesSampled, sampled + 1);
    EXPECT_TRUE(scene.scene->getStatistics().messages.empty());
}

TEST(Deforming, ASkinOfTheGraphicsCardIsFeltAtRestWithAWarning)
{
    Rig rig(new osgAnimation::RigTransformHardware);
    rig.lift(0.03);
    Scene scene(rig.skeleton);
    scene.surface->setName("glove");
    HeadlessViewer viewer(scene.scene);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return scene.result() && scene.result()->points.size() > 0; }));
    EXPECT_LT(scene.offPlane(1, 0.0), 1e-7);
    EXPECT_TRUE(
        scene.says("HapticSurface 'glove': RigGeometry 'skin' is deformed by the graphics card "
                   "(RigTransformHardware); it is felt in its rest pose"));
}

TEST(Deforming, PointsFollowAMorph)
{
    osg::ref_ptr<osgAnimation::MorphGeometry> morph = new osgAnimation::MorphGeometry(*plate());
    const osg::ref_ptr<osg::Geometry> target = plate();
    for (osg::Vec3& v : static_cast<osg::Vec3Array&>(*target->getVertexArray()))
        v.z() = 0.5f * v.x();
    morph->addMorphTarget(target, 0.0f);
    morph->addUpdateCallback(new osgAnimation::UpdateMorphGeometry);
    Scene scene(morph);
    HeadlessViewer viewer(scene.scene);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return scene.result() && scene.result()->points.size() > 0; }));
    EXPECT_LT(scene.offPlane(0, 0.0), 1e-7);
    const std::uint64_t sampled = scene.scene->getStatistics().meshesSampled;
    for (const float weight : {0.25f, 0.5f, 1.0f})
    {
        morph->setWeight(0, weight);
        viewer.frame();
        const unsigned int frame = viewer.viewer.getFrameStamp()->getFrameNumber();
        ASSERT_TRUE(viewer.framesUntil([&] { return scene.result()->frame >= frame; }));
        EXPECT_LT(scene.offPlane(0, 0.5 * static_cast<double>(weight)), 1e-7) << weight;
    }
    EXPECT_EQ(scene.scene->getStatistics().meshesSampled, sampled);
}

TEST(Deforming, WhatMovesInsideAnObjectIsNotReadAgain)
{
    osg::ref_ptr<osg::Group> machine = new osg::Group;
    osg::ref_ptr<osg::MatrixTransform> lever = new osg::MatrixTransform;
    lever->addChild(BoxScene::box(0.02f));
    machine->addChild(BoxScene::box(0.03f));
    machine->addChild(lever);
    Scene scene(machine);
    const auto turn = [&](double angle)
    {
        lever->setMatrix(osg::Matrixd::translate(0.04, 0.0, 0.0) *
                         osg::Matrixd::rotate(angle, osg::Vec3d(0.0, 0.0, 1.0)));
    };
    turn(0.0);
    HeadlessViewer viewer(scene.scene);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return scene.result() && scene.result()->points.size() > 0; }));
    turn(0.1);
    viewer.frame();
    const std::uint64_t read = scene.scene->getStatistics().meshesRead;
    for (int i = 2; i < 20; ++i)
    {
        turn(0.1 * i);
        viewer.frame();
    }
    const unsigned int frame = viewer.viewer.getFrameStamp()->getFrameNumber();
    ASSERT_TRUE(viewer.framesUntil([&] { return scene.result()->frame >= frame; }));
    EXPECT_EQ(scene.scene->getStatistics().meshesRead, read);
    EXPECT_LE(scene.scene->getStatistics().meshesSampled, 3u) << "as one, and as two parts";
    EXPECT_EQ(scene.scene->getStatistics().objects, 1) << "still one object";
    // The lever's outermost points: its corners, 50 mm out and 10 mm aside, turned by 1.9.
    const Eigen::Matrix3Xd& p = scene.result()->points.positions;
    EXPECT_NEAR(p.topRows<2>().colwise().norm().maxCoeff(), std::hypot(0.05, 0.01), 1e-6);
    const Eigen::Vector2d middle = 0.04 * Eigen::Vector2d(std::cos(1.9), std::sin(1.9));
    int onLever = 0;
    for (Eigen::Index i = 0; i < p.cols(); ++i)
        if ((p.col(i).head<2>() - middle).norm() < 0.015) ++onLever;
    EXPECT_GE(onLever, 8);
}

TEST(Deforming, WhatTurnsWithTheCameraIsFeltUnturned)
{
    Scene scene(plate());
    osg::ref_ptr<osg::AutoTransform> turning = new osg::AutoTransform;
    turning->setAutoRotateMode(osg::AutoTransform::ROTATE_TO_SCREEN);
    turning->setPosition(osg::Vec3d(0.01, 0.0, 0.0));
    scene.at->removeChild(scene.surface);
    scene.at->addChild(turning);
    turning->addChild(scene.surface);
    HeadlessViewer viewer(scene.scene);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return scene.result() && scene.result()->points.size() > 0; }));
    // What a cull traversal leaves behind.
    turning->setRotation(osg::Quat(1.0, osg::Vec3d(1.0, 0.0, 0.0)));
    const std::uint64_t solves = scene.scene->getStatistics().solves;
    viewer.frames(20);
    EXPECT_EQ(scene.scene->getStatistics().solves, solves);
    EXPECT_LT(scene.offPlane(1, 0.0), 1e-7);
    EXPECT_NEAR(scene.result()->points.positions.row(0).minCoeff(), 0.01, 1e-7);
    EXPECT_TRUE(scene.says("hangs on what turns with the camera on screen; it is felt unturned"));
}
