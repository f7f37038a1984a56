#include "plugin/scene/SceneCollector.h"

#include "tests/plugin/KitTest.h"

#include <osg/Geometry>

#include <limits>

#include <gtest/gtest.h>

using namespace osgMidair;
using midair::bridge::HapticObject;

namespace
{

osg::ref_ptr<osg::Geometry> triangle()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
    corners->push_back({0.0f, 0.0f, 0.0f});
    corners->push_back({1.0f, 0.0f, 0.0f});
    corners->push_back({0.0f, 1.0f, 0.0f});
    geometry->setVertexArray(corners);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
    return geometry;
}

/// Two objects next to each other: one on a transform, one around a transform of its own.
struct CollectorTest : testing::Test
{
    CollectorTest()
    {
        mover->addChild(first);
        inner->addChild(triangle());
        second->addChild(triangle());
        second->addChild(inner);
        scene->addChild(mover);
        scene->addChild(second);
        EXPECT_TRUE(frame()) << "the first time all is new";
        EXPECT_FALSE(frame());
    }

    /// Whether anything changed; what stands in the objects is compared with what a new collector
    /// finds.
    bool frame()
    {
        const bool changed = collector.collect({{scene.get(), osg::Matrixd()}}, objects);
        midair::base::MessageLog ignored;
        SceneCollector anew(nullptr, [&]() -> midair::base::MessageLog& { return ignored; });
        std::vector<HapticObject> expected;
        anew.collect({{scene.get(), osg::Matrixd()}}, expected);
        if (objects.size() > 2) return changed; // a part of its own, which only time can tell
        EXPECT_EQ(objects.size(), expected.size());
        for (std::size_t i = 0; i < std::min(objects.size(), expected.size()); ++i)
        {
            EXPECT_EQ(objects[i].whole, expected[i].whole);
            EXPECT_EQ(objects[i].properties, expected[i].properties);
            EXPECT_EQ(objects[i].touchEvents, expected[i].touchEvents);
            EXPECT_TRUE(objects[i].pose.isApprox(expected[i].pose));
            EXPECT_EQ(objects[i].mesh->vertices, expected[i].mesh->vertices);
        }
        return changed;
    }

    /// The change is seen in one frame and at rest in the next.
    void expectOneChange(const char* what)
    {
        EXPECT_TRUE(frame()) << what;
        EXPECT_FALSE(frame()) << what;
    }

    osg::ref_ptr<HapticScene> scene = new HapticScene;
    osg::ref_ptr<osg::MatrixTransform> mover = new osg::MatrixTransform;
    osg::ref_ptr<osg::MatrixTransform> inner = new osg::MatrixTransform;
    osg::ref_ptr<osg::Geometry> shape = triangle();
    osg::ref_ptr<HapticSurface> first = new HapticSurface(shape.get());
    osg::ref_ptr<HapticSurface> second = new HapticSurface;
    /// How often something was said.
    std::uint64_t said() const
    {
        std::uint64_t count = 0;
        for (const midair::base::Message& message : log.messages())
            count += message.count;
        return count;
    }

    midair::base::MessageLog log;
    SceneCollector collector{nullptr, [this]() -> midair::base::MessageLog& { return log; }};
    std::vector<HapticObject> objects;
};

} // namespace

TEST_F(CollectorTest, SeesWhateverChangesOnce)
{
    mover->setMatrix(osg::Matrixd::translate(0.1, 0.0, 0.0));
    expectOneChange("moved");
    mover->setMatrix(osg::Matrixd::scale(2.0, 2.0, 2.0));
    expectOneChange("scaled");
    (*static_cast<osg::Vec3Array*>(shape->getVertexArray()))[1].x() = 0.5f;
    shape->getVertexArray()->dirty();
    expectOneChange("morphed");
    first->setPressure(0.5);
    expectOneChange("another pressure");
    first->setTouchEvents(true);
    expectOneChange("touch events");
    first->setEnabled(false);
    expectOneChange("not felt any more");
    first->setEnabled(true);
    expectOneChange("felt again");
    mover->setNodeMask(0);
    expectOneChange("hidden");
    mover->setNodeMask(~0u);
    expectOneChange("shown again");
    scene->removeChild(second);
    expectOneChange("removed");
    scene->insertChild(0, second);
    expectOneChange("put before the other one");
    EXPECT_EQ(said(), 0U);
}

TEST_F(CollectorTest, SeesATransformWithinAnObjectMove)
{
    inner->setMatrix(osg::Matrixd::translate(0.0, 0.0, 0.2));
    EXPECT_TRUE(frame()); // read anew: what is below it is a part of its own from now on
    ASSERT_EQ(objects.size(), 3u);
    frame();
    for (double z : {0.3, 0.4})
    {
        inner->setMatrix(osg::Matrixd::translate(0.0, 0.0, z));
        expectOneChange("moved");
        ASSERT_EQ(objects.size(), 3u);
        EXPECT_EQ(objects[2].pose.translation().z(), z);
    }
}

TEST_F(CollectorTest, MakesAllAnewWhereTheObjectsWereGivenAway)
{
    objects.assign(7, HapticObject());
    collector.forget();
    expectOneChange("given away");
    Eigen::Matrix4d toArray = Eigen::Matrix4d::Identity();
    toArray(0, 3) = 0.5;
    collector.configure(toArray, false);
    EXPECT_TRUE(collector.collect({{scene.get(), osg::Matrixd()}}, objects));
    EXPECT_EQ(objects[0].pose.translation().x(), 0.5);
}

TEST_F(CollectorTest, KeepsTheMeshOfWhatRestsAndThenBlinks)
{
    const std::uint64_t mesh = objects[0].meshId;
    const auto frames = [&](int count)
    {
        for (int i = 0; i < count; ++i)
            collector.collect({{scene.get(), osg::Matrixd()}}, objects);
    };
    frames(2 * midair::bridge::MeshCache::kKeptFrames);
    mover->setNodeMask(0);
    frames(100);
    mover->setNodeMask(~0u);
    frames(1);
    EXPECT_EQ(objects[0].meshId, mesh);
    EXPECT_EQ(collector.extractions(), 2u);
}

TEST_F(CollectorTest, SaysWhatCanNotBeFeltOnceAndGoesOn)
{
    mover->setMatrix(osg::Matrixd::scale(1.0, 0.0, 1.0));
    frame();
    frame();
    frame();
    ASSERT_EQ(said(), 1U);
    EXPECT_EQ(log.all()[0],
              "HapticScene/MatrixTransform/HapticSurface: its matrix is singular, not finite or a "
              "perspective; it can't be felt");
    EXPECT_EQ(collector.instances(), 1);
    EXPECT_EQ(objects.size(), 1u);
}

// OSG's own comparison takes a matrix with NaN for equal to the one before.
TEST_F(CollectorTest, AMatrixThatIsNotFiniteIsAChangeAndSoIsTheNextOne)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {nan, std::numeric_limits<double>::infinity()})
    {
        const std::uint64_t before = said();
        mover->setMatrix(osg::Matrixd::translate(bad, 0.0, 0.0));
        expectOneChange("not finite");
        EXPECT_EQ(objects.size(), 1u) << "it isn't felt at its old place";
        EXPECT_EQ(said(), before + 1);
        EXPECT_TRUE(log.messages().back().isActive);
        mover->setMatrix(osg::Matrixd::translate(0.1, 0.0, 0.0));
        expectOneChange("good again");
        EXPECT_FALSE(log.messages().back().isActive);
        EXPECT_EQ(objects.size(), 2u);
    }
}

TEST_F(CollectorTest, WhatIsNotFiniteFromTheFirstFrameOnIsFeltOnceItIs)
{
    mover->setMatrix(osg::Matrixd::translate(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));
    midair::base::MessageLog ignored;
    SceneCollector late(nullptr, [&]() -> midair::base::MessageLog& { return ignored; });
    std::vector<HapticObject> found;
    late.collect({{scene.get(), osg::Matrixd()}}, found);
    EXPECT_EQ(found.size(), 1u);
    mover->setMatrix(osg::Matrixd::translate(0.1, 0.0, 0.0));
    EXPECT_TRUE(late.collect({{scene.get(), osg::Matrixd()}}, found));
    EXPECT_EQ(found.size(), 2u);
}
