#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"

#include <osg/Geometry>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A scene that has come to rest in a viewer.
struct Rest : testing::Test
{
    Rest() : viewer(box.scene) { EXPECT_TRUE(comesToRest()); }

    bool comesToRest()
    {
        const std::uint64_t before = box.scene->getStatistics().restingFrames;
        return viewer.framesUntil([&]
                                  { return box.scene->getStatistics().restingFrames > before; });
    }

    std::uint64_t snapshots() const { return box.scene->getStatistics().snapshots; }

    /// Whether a change is seen by the very next frame, whenever that comes.
    bool seenAtOnce()
    {
        const std::uint64_t before = snapshots();
        viewer.frame();
        return snapshots() == before + 1;
    }

    bool seenInTime()
    {
        const std::uint64_t before = snapshots();
        return viewer.framesUntil([&] { return snapshots() > before; });
    }

    BoxScene box;
    HeadlessViewer viewer;
};

} // namespace

TEST_F(Rest, FramesAreCountedAndSolveNothing)
{
    const HapticStatistics before = box.scene->getStatistics();
    viewer.frames(20);
    const HapticStatistics after = box.scene->getStatistics();
    EXPECT_EQ(after.frames, before.frames + 20);
    EXPECT_EQ(after.idleFrames, before.idleFrames + 20);
    EXPECT_GT(after.restingFrames, before.restingFrames);
    EXPECT_EQ(after.snapshots, 1u);
}

TEST_F(Rest, AMovedTransformIsSeenByTheNextFrame)
{
    for (double x : {0.001, 0.002, 0.003})
    {
        box.transform->setMatrix(osg::Matrixd::translate(x, 0.0, 0.1));
        EXPECT_TRUE(seenAtOnce()) << x;
        ASSERT_TRUE(comesToRest());
    }
}

TEST_F(Rest, AnObjectThatComesOrGoesIsSeenByTheNextFrame)
{
    box.transform->removeChild(box.surface);
    EXPECT_TRUE(seenAtOnce());
    ASSERT_TRUE(comesToRest());
    box.transform->addChild(box.surface);
    EXPECT_TRUE(seenAtOnce());
}

TEST_F(Rest, WhatNoBoundShowsIsSeenWithTheNextLook)
{
    box.transform->setNodeMask(0);
    EXPECT_TRUE(seenInTime());
    ASSERT_TRUE(comesToRest());
    box.transform->setNodeMask(~0u);
    EXPECT_TRUE(seenInTime());
}

TEST_F(Rest, WhatASetterChangesIsSeenByTheNextFrame)
{
    for (const double pressure : {0.5, 0.6, 0.7})
    {
        box.surface->setPressure(pressure);
        EXPECT_TRUE(seenAtOnce()) << pressure;
        ASSERT_TRUE(comesToRest());
    }
    box.scene->setLoudness(0.5);
    EXPECT_TRUE(seenAtOnce());
    ASSERT_TRUE(comesToRest());
    box.surface->setSampling(HapticProperty::EDGES);
    EXPECT_TRUE(seenAtOnce());
    ASSERT_TRUE(comesToRest());
    box.scene->setEnabled(false);
    EXPECT_TRUE(seenAtOnce());
}

TEST_F(Rest, TakenOutOfThePictureItIsSilent)
{
    viewer.viewer.setSceneData(new osg::Group);
    EXPECT_TRUE(viewer.framesUntil(
        [&]
        {
            const auto result = SceneAccess::latestResult(*box.scene);
            return result && result->points.size() == 0;
        }));
}

// Surfaces ask for events only to be found: that doesn't lead every event of every frame through
// what is below them.
TEST_F(Rest, EventsGoBelowASurfaceOnlyToWhoAskedForThem)
{
    struct Child : osg::Group
    {
        void traverse(osg::NodeVisitor& visitor) override
        {
            visits += visitor.getVisitorType() == osg::NodeVisitor::EVENT_VISITOR ? 1 : 0;
            osg::Group::traverse(visitor);
        }
        int visits = 0;
    };
    struct Asks : osg::NodeCallback
    {
        void operator()(osg::Node* node, osg::NodeVisitor* visitor) override
        {
            ++calls;
            traverse(node, visitor);
        }
        int calls = 0;
    };
    osg::ref_ptr<Child> quiet = new Child;
    box.surface->addChild(quiet);
    viewer.frames(3);
    EXPECT_EQ(quiet->visits, 0);
    osg::ref_ptr<osg::Group> asking = new osg::Group;
    osg::ref_ptr<Asks> asks = new Asks;
    asking->setEventCallback(asks);
    box.surface->addChild(asking);
    viewer.frames(3);
    EXPECT_GE(asks->calls, 3);
}

TEST_F(Rest, HandsAreFollowedInEveryFrame)
{
    box.scene->setHandSource(new InjectedHands);
    viewer.framesUntil([] { return true; });
    const std::uint64_t before = box.scene->getStatistics().restingFrames;
    viewer.framesFor(0.8);
    EXPECT_LE(box.scene->getStatistics().restingFrames, before);
}
