// What nobody leads any more is silent within a frame, whoever holds a reference to it.
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticDevice>

#include <osg/Switch>

#include <functional>
#include <memory>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Passes on to the callbacks nested in it, or to one that it has for itself.
struct Passing : osg::NodeCallback
{
    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override
    {
        if (own) (*own)(node, visitor);
        traverse(node, visitor);
    }
    osg::ref_ptr<HapticCallback> own;
};

/// A box below a node, in a graph that a viewer shows.
struct Led
{
    osg::ref_ptr<osg::Switch> root = new osg::Switch;
    osg::ref_ptr<osg::Group> node = new osg::Group;
    osg::ref_ptr<HapticCallback> callback = new HapticCallback(settings());
    osg::ref_ptr<Passing> passing = new Passing;
    std::unique_ptr<HeadlessViewer> viewer = std::make_unique<HeadlessViewer>(root);

    Led()
    {
        osg::ref_ptr<osg::MatrixTransform> at =
            new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
        at->addChild(new HapticSurface(BoxScene::box()));
        node->addChild(at);
        root->addChild(node);
    }

    static HapticSettings settings()
    {
        HapticSettings all;
        all.array = "board";
        return all;
    }
    bool plays() const { return callback->getStatistics().state == ArrayState::PLAYING; }
    std::uint64_t solves() const { return callback->getStatistics().solves; }
    bool isSolved() const
    {
        const HapticStatistics now = callback->getStatistics();
        return now.processed >= now.snapshots;
    }

    /// Moves the box and runs a frame.
    void frame()
    {
        ++_moves;
        auto& at = dynamic_cast<osg::MatrixTransform&>(*node->getChild(0));
        at.setMatrix(osg::Matrixd::translate(1e-3 * (_moves % 7), 0.0, 0.15));
        viewer->frame();
    }

private:
    int _moves = 0;
};

struct Way
{
    const char* name;
    std::function<void(Led&)> add;
    std::function<void(Led&)> remove;
    std::function<void(Led&)> again;
};

std::vector<Way> ways()
{
    const auto addEvent = [](Led& led) { led.node->addEventCallback(led.callback); };
    const auto addUpdate = [](Led& led) { led.node->addUpdateCallback(led.callback); };
    const auto nest = [](Led& led)
    {
        led.passing->addNestedCallback(led.callback);
        led.node->setEventCallback(led.passing);
    };
    return {
        {"removeEventCallback",
         addEvent,
         [](Led& led) { led.node->removeEventCallback(led.callback); },
         addEvent},
        {"removeUpdateCallback",
         addUpdate,
         [](Led& led) { led.node->removeUpdateCallback(led.callback); },
         addUpdate},
        {"setUpdateCallback",
         addUpdate,
         [](Led& led) { led.node->setUpdateCallback(new Passing); },
         addUpdate},
        {"removeNestedCallback",
         nest,
         [](Led& led) { led.passing->removeNestedCallback(led.callback); },
         [](Led& led) { led.passing->addNestedCallback(led.callback); }},
        {"setEventCallback of the chain",
         nest,
         [](Led& led) { led.node->setEventCallback(nullptr); },
         [](Led& led) { led.node->setEventCallback(led.passing); }},
        {"the callback that calls it",
         [](Led& led)
         {
             led.passing->own = led.callback;
             led.node->addEventCallback(led.passing);
         },
         [](Led& led) { led.passing->own = nullptr; },
         [](Led& led) { led.passing->own = led.callback; }},
        {"removeChild",
         addEvent,
         [](Led& led) { led.root->removeChild(led.node); },
         [](Led& led) { led.root->addChild(led.node); }},
        {"a switch",
         addEvent,
         [](Led& led) { led.root->setAllChildrenOff(); },
         [](Led& led) { led.root->setAllChildrenOn(); }},
        {"a node mask",
         addEvent,
         [](Led& led) { led.node->setNodeMask(0); },
         [](Led& led) { led.node->setNodeMask(~0U); }},
        {"setSceneData",
         addEvent,
         [](Led& led) { led.viewer->viewer.setSceneData(new osg::Group); },
         [](Led& led) { led.viewer->viewer.setSceneData(led.root); }},
    };
}

} // namespace

TEST(Lead, ACallbackThatWasTakenAwayIsSilentWithinAFrame)
{
    for (const Way& way : ways())
    {
        Led led;
        way.add(led);
        const auto plays = [&]
        {
            led.frame();
            return led.plays();
        };
        ASSERT_TRUE(led.viewer->framesUntil(plays)) << way.name;
        for (int i = 0; i < 20; ++i)
            led.frame();
        EXPECT_TRUE(led.viewer->framesUntil(plays)) << way.name << ": it goes on";
        way.remove(led);
        led.frame();
        EXPECT_FALSE(led.plays()) << way.name;
        EXPECT_TRUE(eventually([&] { return led.isSolved(); })); // what was under way
        const std::uint64_t solves = led.solves();
        for (int i = 0; i < 99; ++i)
        {
            led.frame();
            EXPECT_FALSE(led.plays()) << way.name << ", frame " << i;
        }
        EXPECT_LE(led.solves(), solves) << way.name << ": solved for nobody";
        way.again(led);
        EXPECT_TRUE(led.viewer->framesUntil(plays)) << way.name << ": put back";
    }
}

TEST(Lead, ACallbackThatWasTakenAwayKeepsNeitherItsDeviceNorItsScene)
{
    Led led;
    HapticSettings settings = Led::settings();
    settings.device = "record:" + testing::TempDir() + "midair-lead.recording";
    led.callback->setSettings(settings);
    osg::ref_ptr<HapticScene> inner = new HapticScene;
    inner->setArray("board");
    inner->addChild(led.node->getChild(0));
    led.node->removeChildren(0, 1);
    led.node->addChild(inner);
    led.node->addEventCallback(led.callback);
    ASSERT_TRUE(led.viewer->framesUntil([&] { return led.plays(); }));
    EXPECT_NE(inner->getStatistics().state, ArrayState::PLAYING);
    led.node->removeEventCallback(led.callback);
    inner->setDevice(settings.device);
    EXPECT_TRUE(led.viewer->framesUntil(
        [&] { return inner->getStatistics().state == ArrayState::PLAYING; }))
        << "its file is free, and the scene inside plays for itself";
    EXPECT_EQ(led.callback->getStatistics().state, ArrayState::CLOSED);
}

TEST(Lead, ADeviceThatWasTakenAwayIsSilentWithinAFrame)
{
    Led led;
    osg::ref_ptr<HapticDevice> device = new HapticDevice(Led::settings());
    led.viewer->viewer.addDevice(device);
    const auto plays = [&] { return device->getStatistics().state == ArrayState::PLAYING; };
    ASSERT_TRUE(led.viewer->framesUntil(plays));
    led.viewer->viewer.removeDevice(device);
    led.frame();
    EXPECT_FALSE(plays());
    led.viewer->viewer.addDevice(device);
    EXPECT_TRUE(led.viewer->framesUntil(plays));
}

TEST(Lead, ASceneThatIsShownNoLongerIsSilentWithinAFrame)
{
    const std::function<void(BoxScene&, HeadlessViewer&)> ways[] = {
        [](BoxScene&, HeadlessViewer& viewer) { viewer.viewer.setSceneData(new osg::Group); },
        [](BoxScene& box, HeadlessViewer&) { box.scene->setNodeMask(0); },
        [](BoxScene& box, HeadlessViewer&) { box.surface->setNodeMask(0); },
        [](BoxScene& box, HeadlessViewer&) { box.scene->removeChild(box.transform); },
    };
    for (std::size_t i = 0; i < std::size(ways); ++i)
    {
        BoxScene box;
        HeadlessViewer viewer(box.scene);
        const auto plays = [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; };
        ASSERT_TRUE(viewer.framesUntil(plays));
        const auto rests = [&] { return box.scene->getStatistics().restingFrames > 0; };
        ASSERT_TRUE(viewer.framesUntil(rests)) << i; // frames in which nothing is looked at
        ways[i](box, viewer);
        viewer.frame();
        // A mask below the root is found by the next look, ten times a second.
        if (i == 2)
        {
            EXPECT_TRUE(viewer.framesUntil([&] { return !plays(); }));
        }
        EXPECT_FALSE(plays()) << i;
    }
}

TEST(Lead, AViewerThatEndsLeavesSilence)
{
    BoxScene box;
    auto viewer = std::make_unique<HeadlessViewer>(box.scene);
    const auto plays = [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; };
    ASSERT_TRUE(viewer->framesUntil(plays));
    viewer.reset();
    EXPECT_FALSE(plays());
    HeadlessViewer another(box.scene);
    EXPECT_TRUE(another.framesUntil(plays)) << "and another goes on";
}

TEST(Lead, AViewerThatIsLeftByItsSceneDoesNotSilenceTheOneThatShowsIt)
{
    BoxScene box;
    auto first = std::make_unique<HeadlessViewer>(box.scene);
    const auto plays = [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; };
    ASSERT_TRUE(first->framesUntil(plays));
    HeadlessViewer second(box.scene);
    second.frames(3);
    first.reset();
    EXPECT_TRUE(plays());
    second.frames(3);
    EXPECT_TRUE(plays());
}
