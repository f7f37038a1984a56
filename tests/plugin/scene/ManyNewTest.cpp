// Many small meshes that appear at once come over several frames, each whole.
#include "engine-bridge/scene/MeshCache.h"
#include "plugin/scene/SceneCollector.h"
#include "tests/plugin/KitTest.h"

#include <osg/ValueObject>

#include <algorithm>

#include <gtest/gtest.h>

using namespace osgMidair;
using midair::bridge::HapticObject;
using midair::bridge::MeshCache;

namespace
{

constexpr int kMany = 200;
/// What a frame reads at most of those that are new: each costs more than this.
constexpr std::size_t kMost = MeshCache::kFrameBytes / MeshCache::kSubtreeWork;

osg::ref_ptr<osg::Node> ball()
{
    return new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(0.0f, 0.0f, 0.15f), 0.01f));
}

void addBalls(osg::Group& scene, int count)
{
    for (int i = 0; i < count; ++i)
        scene.addChild(new HapticSurface(ball().get()));
}

osg::ref_ptr<HapticScene> emptyScene()
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setDevice("null:");
    scene->setArray("board");
    return scene;
}

/// Collects a scene without playing it.
struct Frames
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    midair::base::MessageLog log;
    SceneCollector collector{nullptr, [this]() -> midair::base::MessageLog& { return log; }};
    std::vector<HapticObject> objects;

    void collect() { collector.collect({{scene.get(), osg::Matrixd()}}, objects); }
};

} // namespace

TEST(ManyNew, ComeOverSeveralFramesWhichSayHowManyWait)
{
    const auto scene = emptyScene();
    addBalls(*scene, kMany);
    HapticStatistics before;
    int frames = 0;
    do
    {
        scene->update(nullptr);
        const HapticStatistics now = scene->getStatistics();
        EXPECT_EQ(now.objects + now.objectsBeingRead, kMany);
        EXPECT_GT(now.objects, before.objects) << "at least one in each frame";
        EXPECT_LE(now.meshesRead - before.meshesRead, kMost);
        before = now;
    } while (before.objectsBeingRead > 0 && ++frames < kMany);
    EXPECT_GE(frames, 5);
    EXPECT_EQ(before.objects, kMany);
    EXPECT_EQ(before.restingFrames, 0u);
    EXPECT_EQ(scene->getFoundObjects().size(), std::size_t(kMany));
}

TEST(ManyNew, ALoopDoesNotRestWhileSomeWait)
{
    const auto scene = emptyScene();
    addBalls(*scene, 1);
    const auto rests = [&]
    {
        scene->update(nullptr);
        return scene->getStatistics().restingFrames > 0;
    };
    ASSERT_TRUE(eventually(rests));
    addBalls(*scene, kMany);
    const std::uint64_t resting = scene->getStatistics().restingFrames;
    do
    {
        scene->update(nullptr);
        ASSERT_EQ(scene->getStatistics().restingFrames, resting);
    } while (scene->getStatistics().objectsBeingRead > 0);
    EXPECT_EQ(scene->getStatistics().objects, kMany + 1);
}

TEST(ManyNew, WhatIsFeltAlreadyStaysAsItIs)
{
    Frames frames;
    addBalls(*frames.scene, 1);
    frames.collect();
    ASSERT_EQ(frames.objects.size(), 1u);
    const HapticObject first = frames.objects.front();
    addBalls(*frames.scene, kMany);
    do
    {
        frames.collect();
        const auto same = std::find_if(frames.objects.begin(),
                                       frames.objects.end(),
                                       [&](const HapticObject& one) { return one.id == first.id; });
        ASSERT_NE(same, frames.objects.end());
        EXPECT_EQ(same->meshId, first.meshId);
        for (const HapticObject& one : frames.objects)
            EXPECT_EQ(one.mesh->triangles.cols(), first.mesh->triangles.cols()) << "whole";
    } while (frames.collector.beingRead() > 0);
    EXPECT_EQ(frames.objects.size(), std::size_t(kMany + 1));
}

TEST(ManyNew, OneThatSilencesTheSceneDoesSoBeforeItIsRead)
{
    Frames frames;
    addBalls(*frames.scene, kMany);
    const osg::ref_ptr<osg::Group> unclear = new osg::Group;
    unclear->setUserValue("haptic", std::string("pressure=loud"));
    unclear->addChild(ball());
    frames.scene->addChild(unclear);
    frames.collect();
    ASSERT_GT(frames.collector.beingRead(), 0);
    EXPECT_TRUE(frames.collector.isSilenced());
}

TEST(ManyNew, OfOneNodeInManyPlacesMoreComeInAFrame)
{
    Frames frames;
    const osg::ref_ptr<osg::Node> one = new HapticSurface(ball().get());
    for (int i = 0; i < kMany; ++i)
    {
        frames.scene->addChild(new osg::MatrixTransform);
        frames.scene->getChild(static_cast<unsigned int>(i))->asGroup()->addChild(one);
    }
    frames.collect();
    EXPECT_GT(frames.objects.size(), 2 * kMost);
}

TEST(ManyNew, SurfacesThatShareADrawableShareItsSamples)
{
    const auto scene = emptyScene();
    const auto drawable = ball();
    for (int i = 0; i < 5; ++i)
        scene->addChild(new HapticSurface(drawable.get()));
    scene->update(nullptr);
    ASSERT_EQ(scene->getStatistics().objects, 5);
    EXPECT_TRUE(eventually([&] { return scene->getStatistics().processed > 0; }));
    EXPECT_EQ(scene->getStatistics().meshesSampled, 1u);
}
