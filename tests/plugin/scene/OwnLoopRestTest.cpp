// A loop of a program's own that calls HapticScene::update() rests as an osgViewer does.
#include "tests/plugin/KitTest.h"

#include <osg/Geometry>
#include <osg/Switch>
#include <osg/ValueObject>

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A scene that has come to rest in a loop of its own.
struct RestInOwnLoop : testing::Test
{
    RestInOwnLoop()
    {
        box.scene->setDevice("null:");
        (*vertices)[0].set(0.0f, 0.0f, 0.12f);
        (*vertices)[1].set(0.03f, 0.0f, 0.12f);
        (*vertices)[2].set(0.0f, 0.03f, 0.12f);
        const osg::ref_ptr<osg::Geometry> triangle = new osg::Geometry;
        triangle->setVertexArray(vertices);
        triangle->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
        tagged->addChild(triangle);
        tagged->setUserValue("haptic", std::string("pressure=0.5"));
        switched->addChild(tagged);
        box.scene->addChild(switched);
        EXPECT_TRUE(comesToRest());
    }

    HapticStatistics statistics() const { return box.scene->getStatistics(); }

    void update() { box.scene->update(stamp, world); }

    bool rests()
    {
        const std::uint64_t before = statistics().restingFrames;
        update();
        return statistics().restingFrames > before;
    }

    bool comesToRest()
    {
        return eventually([this] { return rests(); });
    }

    BoxScene box;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array(3);
    osg::ref_ptr<osg::Group> tagged = new osg::Group;
    osg::ref_ptr<osg::Switch> switched = new osg::Switch;
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    osg::Matrixd world;
};

struct Change
{
    const char* name;
    bool isAtOnce; ///< else with the next look, HapticEngine::kLook_s later at the latest
    std::function<void(RestInOwnLoop&)> make;
};

const std::vector<Change> kChanges = {
    {"a matrix",
     true,
     [](RestInOwnLoop& t) { t.box.transform->setMatrix(osg::Matrixd::translate(0.0, 0.0, 0.14)); }},
    {"the world around the scene",
     true,
     [](RestInOwnLoop& t) { t.world = osg::Matrixd::translate(0.001, 0.0, 0.0); }},
    {"a child that goes",
     true,
     [](RestInOwnLoop& t) { t.box.transform->removeChild(t.box.surface); }},
    {"a child that comes",
     true,
     [](RestInOwnLoop& t) { t.box.transform->addChild(t.box.surface); }},
    {"a property", true, [](RestInOwnLoop& t) { t.box.surface->setPressure(0.5); }},
    {"a setting", true, [](RestInOwnLoop& t) { t.box.scene->setLoudness(0.5); }},
    {"silence()", true, [](RestInOwnLoop& t) { t.box.scene->silence(); }},
    {"a Switch", false, [](RestInOwnLoop& t) { t.switched->setAllChildrenOff(); }},
    {"a Switch back", false, [](RestInOwnLoop& t) { t.switched->setAllChildrenOn(); }},
    {"a node mask", false, [](RestInOwnLoop& t) { t.box.transform->setNodeMask(0); }},
    {"a node mask back", false, [](RestInOwnLoop& t) { t.box.transform->setNodeMask(~0u); }},
    {"vertices with dirty()",
     false,
     [](RestInOwnLoop& t)
     {
         (*t.vertices)[0].z() += 0.01f;
         t.vertices->dirty();
     }},
    {"vertices without it", false, [](RestInOwnLoop& t) { (*t.vertices)[0].z() -= 0.01f; }},
    {"a tag",
     false,
     [](RestInOwnLoop& t) { t.tagged->setUserValue("haptic", std::string("pressure=0.7")); }},
};

} // namespace

TEST_F(RestInOwnLoop, WhateverIsFeltOtherwiseEndsIt)
{
    for (const Change& change : kChanges)
    {
        SCOPED_TRACE(change.name);
        ASSERT_TRUE(comesToRest());
        change.make(*this);
        const std::uint64_t before = statistics().snapshots;
        if (change.isAtOnce) update();
        const auto isSeen = [&]
        {
            if (!change.isAtOnce) update();
            return statistics().snapshots > before;
        };
        EXPECT_TRUE(change.isAtOnce ? isSeen() : eventually(isSeen));
    }
}

TEST_F(RestInOwnLoop, FramesAreCountedAndCollectNothing)
{
    const HapticStatistics before = statistics();
    for (int i = 0; i < 20; ++i)
        update();
    const HapticStatistics after = statistics();
    EXPECT_EQ(after.frames, before.frames + 20);
    EXPECT_EQ(after.idleFrames, before.idleFrames + 20);
    EXPECT_EQ(after.snapshots, before.snapshots);
}

TEST_F(RestInOwnLoop, TheTimeIsThatOfTheNewestFrame)
{
    ASSERT_TRUE(comesToRest());
    EXPECT_EQ(statistics().collect_ms, 0.0) << "nothing was looked at";
    box.move(0.01);
    update();
    EXPECT_GT(statistics().collect_ms, 0.0);
}

TEST_F(RestInOwnLoop, HandsAreFollowedInEveryFrame)
{
    box.scene->setHandSource(new InjectedHands);
    for (int i = 0; i < 20; ++i)
        EXPECT_FALSE(rests());
}
