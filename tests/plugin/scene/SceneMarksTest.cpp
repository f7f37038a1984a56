// What isn't marked is felt where nothing is marked, and never because a mark is hidden.
#include "plugin/scene/SceneMarks.h"

#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticDevice>

#include <osg/LOD>
#include <osg/PagedLOD>
#include <osg/ProxyNode>
#include <osg/Sequence>
#include <osg/Switch>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

HapticSettings onBoard()
{
    HapticSettings settings;
    settings.array = "board";
    return settings;
}

osg::ref_ptr<osg::MatrixTransform> boxAt(double x, const std::string& name)
{
    osg::ref_ptr<osg::MatrixTransform> box =
        new osg::MatrixTransform(osg::Matrixd::translate(x, 0.0, 0.15));
    box->setName(name);
    box->addChild(BoxScene::box());
    return box;
}

/// A viewer with a --device, whose scene has a floor that isn't marked and a mug that is.
struct Viewed
{
    explicit Viewed(osg::Node* other = nullptr)
    {
        mug->setUserValue("haptic", true);
        root->addChild(boxAt(-0.04, "floor"));
        if (other) root->addChild(other);
        viewer.viewer.addDevice(device);
    }

    /// Objects that are felt in this frame.
    int frame()
    {
        viewer.frame();
        return device->getStatistics().objects;
    }

    /// Runs frames until the mug is felt, and nothing else.
    bool framesUntilMug()
    {
        return viewer.framesUntil(
            [this]
            {
                const auto field = device->getField();
                if (!field || field->getPoints().empty()) return false;
                for (const HapticField::ControlPoint& point : field->getPoints())
                    if (field->getObjects()[point.object].path.find("'mug'") == std::string::npos)
                        return false;
                return true;
            });
    }

    /// How often something with \a code was told.
    std::uint64_t told(const std::string& code) const
    {
        std::uint64_t count = 0;
        for (const HapticMessage& message : device->getStatistics().told)
            if (message.code == code) count += message.count;
        return count;
    }

    osg::ref_ptr<osg::Group> root = new osg::Group;
    osg::ref_ptr<osg::MatrixTransform> mug = boxAt(0.04, "mug");
    osg::ref_ptr<HapticDevice> device = new HapticDevice(onBoard());
    HeadlessViewer viewer{root};
};

/// One way of hiding what is below it.
struct Hiding
{
    std::string name;
    osg::ref_ptr<osg::Group> group;
    std::function<void(bool)> show;
};

std::vector<Hiding> allWaysOfHiding()
{
    const osg::ref_ptr<osg::Group> masked = new osg::Group;
    const osg::ref_ptr<osg::Switch> switched = new osg::Switch;
    const osg::ref_ptr<osg::Sequence> sequence = new osg::Sequence;
    const osg::ref_ptr<osg::LOD> level = new osg::LOD;
    return {{"node mask",
             masked,
             [node = masked.get()](bool shown) { node->setNodeMask(shown ? ~0U : 0U); }},
            {"Switch", switched, [node = switched.get()](bool shown) { node->setValue(0, shown); }},
            {"Sequence",
             sequence,
             [node = sequence.get()](bool shown) { node->setValue(shown ? 0 : -1); }},
            {"LOD", level, [node = level.get()](bool shown) {
                 node->setRange(0, shown ? 0.0F : 5.0F, 1e6F);
             }}};
}

} // namespace

TEST(SceneMarks, HidingTheOnlyMarkMakesNothingElseFelt)
{
    for (const Hiding& hiding : allWaysOfHiding())
    {
        SCOPED_TRACE(hiding.name);
        Viewed viewed(hiding.group);
        hiding.group->addChild(viewed.mug);
        hiding.show(false);
        for (int i = 0; i < 5; ++i)
            EXPECT_EQ(viewed.frame(), 0) << "hidden from the first frame on";
        hiding.show(true);
        EXPECT_EQ(viewed.frame(), 1);
        EXPECT_TRUE(viewed.framesUntilMug());
        hiding.show(false);
        for (int i = 0; i < 130; ++i) // marks are looked for twice meanwhile
            ASSERT_EQ(viewed.frame(), 0) << "hidden again";
        EXPECT_EQ(viewed.told("scene.unmarked"), 0U);
        hiding.show(true);
        EXPECT_TRUE(viewed.framesUntilMug());
    }
}

TEST(SceneMarks, WhatIsNotLoadedMayHaveThem)
{
    const osg::ref_ptr<osg::PagedLOD> paged = new osg::PagedLOD;
    paged->setName("tile");
    paged->setFileName(0, "mug.osgt");
    paged->setRange(0, 0.0F, 1e6F);
    Viewed viewed(paged);
    for (int i = 0; i < 130; ++i)
        ASSERT_EQ(viewed.frame(), 0) << "before it arrives";
    EXPECT_EQ(viewed.told("scene.incomplete"), 1U);
    paged->addChild(viewed.mug);
    EXPECT_TRUE(viewed.framesUntilMug()) << "arrived";
    paged->removeChildren(0, 1);
    for (int i = 0; i < 130; ++i)
        ASSERT_EQ(viewed.frame(), 0) << "unloaded again";
    EXPECT_EQ(viewed.told("scene.unmarked"), 0U);
    EXPECT_EQ(viewed.told("scene.incomplete"), 1U);
}

TEST(SceneMarks, WithoutAnyAllIsFeltWhichIsToldOnce)
{
    const osg::ref_ptr<osg::PagedLOD> paged = new osg::PagedLOD;
    paged->setFileName(0, "more.osgt");
    paged->addChild(boxAt(0.0, "more"));
    Viewed viewed(paged);
    EXPECT_EQ(viewed.frame(), 1) << "in the first frame";
    for (int i = 0; i < 130; ++i)
        ASSERT_EQ(viewed.frame(), 1);
    EXPECT_EQ(viewed.told("scene.unmarked"), 1U);
    paged->removeChildren(0, 1);
    for (int i = 0; i < 130; ++i)
        ASSERT_EQ(viewed.frame(), 1) << "what is unloaded had none";
    viewed.mug->setNodeMask(0);
    viewed.root->addChild(viewed.mug);
    EXPECT_TRUE(viewed.viewer.framesUntil([&] { return viewed.frame() == 0; }))
        << "a mark that comes later counts, hidden or not";
    EXPECT_EQ(viewed.told("scene.unmarked"), 1U);
}

TEST(SceneMarks, ASceneWithoutAnySaysSoOnce)
{
    const osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setName("desk");
    scene->setArray("board");
    scene->addChild(boxAt(0.0, "floor"));
    HeadlessViewer viewer(scene);
    viewer.frames(130);
    const std::vector<HapticMessage> told = scene->getStatistics().told;
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].code, "scene.empty");
    EXPECT_EQ(told[0].count, 1U);
    EXPECT_EQ(told[0].path, "HapticScene 'desk'");
}

TEST(SceneMarks, AFileOfAProxyIsMissingUntilItsChildIsThere)
{
    const osg::ref_ptr<osg::ProxyNode> proxy = new osg::ProxyNode;
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    proxy->setName("tile");
    proxy->setFileName(0, "a.osgt");
    root->addChild(proxy);
    SceneMarks marks;
    marks.look({root.get()});
    EXPECT_EQ(marks.state(), SceneMarks::State::UNKNOWN);
    EXPECT_EQ(marks.missing(), "ProxyNode 'tile' (a.osgt)");
    EXPECT_EQ(missingFile(*proxy), "a.osgt");
    proxy->addChild(new osg::Group);
    marks.look({root.get()});
    EXPECT_EQ(marks.state(), SceneMarks::State::NONE);
    EXPECT_EQ(missingFile(*proxy), "");
    const osg::ref_ptr<osg::Group> points = new osg::Group;
    points->addDescription("haptic: pressure=2");
    proxy->setNodeMask(0);
    proxy->getChild(0)->asGroup()->addChild(points);
    markTags(*root);
    marks.look({root.get()});
    EXPECT_EQ(marks.state(), SceneMarks::State::SOME);
    root->removeChildren(0, 1);
    marks.look({root.get()});
    EXPECT_EQ(marks.state(), SceneMarks::State::SOME) << "for good";
}
