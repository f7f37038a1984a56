// Whatever keeps the array silent, no touch has a force.
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HandSource>

#include <functional>
#include <limits>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A finger 2 mm in a box that asks for 300 Pa.
struct PressedBox : BoxScene
{
    osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    HeadlessViewer viewer{scene};

    explicit PressedBox(const std::string& device = "sim:")
    {
        scene->setDevice(device);
        scene->setHandSource(hands);
        surface->setTouchEvents(true);
        surface->setPressureUnit(HapticProperty::PASCAL);
        surface->setPressure(300.0);
    }

    /// A frame with the finger.
    void frame()
    {
        Hand hand = openHand(1, osg::Vec3d(0.0, 0.0, 0.17 + 0.0075 - 0.002), osg::Quat());
        for (std::size_t i = 0; i < Hand::kJoints; ++i)
            hand.joints[i].positionValid = i == 9 || i == 10;
        hands->setHands({hand});
        viewer.frame();
    }
    bool until(const std::function<bool()>& done)
    {
        return viewer.framesUntil(
            [&]
            {
                frame();
                return done();
            });
    }
    /// That of the touch; -1: there is none.
    double force_N() const
    {
        const std::vector<Touch> touches = scene->getTouches();
        return touches.empty() ? -1.0 : touches[0].force;
    }
    ArrayState state() const { return scene->getStatistics().state; }
};

/// Notes the largest force that it was told of.
struct Strongest : TouchCallback
{
    void enter(const Touch& touch) override { note(touch); }
    void stay(const Touch& touch) override { note(touch); }
    void leave(const Touch&) override {}
    void note(const Touch& touch) { force_N = std::max(force_N, touch.force); }
    double force_N = 0.0;

protected:
    ~Strongest() override = default;
};

} // namespace

TEST(SilentForce, IsNoneWhateverSilencesTheArray)
{
    struct Case
    {
        const char* name;
        std::function<void(PressedBox&)> silence;
        bool isAtOnce; ///< needs no frame
        bool touches;  ///< touches go on
    };
    const Case cases[] = {
        {"muted", [](PressedBox& box) { box.scene->setMuted(true); }, true, true},
        {"no amplitude", [](PressedBox& box) { box.scene->setMaxAmplitude(0.0); }, false, true},
        {"a cap that nothing keeps",
         [](PressedBox& box) { box.scene->setMaxPressure(0.01); },
         false,
         true},
        {"disabled", [](PressedBox& box) { box.scene->setEnabled(false); }, false, false},
        {"a limit that isn't one",
         [](PressedBox& box)
         { box.scene->setMaxPressure(std::numeric_limits<double>::quiet_NaN()); },
         false,
         false},
        {"silenced", [](PressedBox& box) { box.scene->silence(); }, true, false},
    };
    for (const Case& one : cases)
    {
        PressedBox box;
        ASSERT_TRUE(box.until([&] { return box.force_N() > 0.0; })) << one.name;
        EXPECT_EQ(box.state(), ArrayState::PLAYING) << one.name;
        one.silence(box);
        const double silent_N = one.touches ? 0.0 : -1.0;
        if (one.isAtOnce)
        {
            EXPECT_EQ(box.force_N(), silent_N) << one.name;
            if (!one.touches) continue;
        }
        for (int i = 0; i < 5; ++i)
        {
            box.frame();
            EXPECT_EQ(box.force_N(), silent_N) << one.name << ", frame " << i;
        }
    }
}

TEST(SilentForce, ComesBackWithTheSound)
{
    PressedBox box;
    ASSERT_TRUE(box.until([&] { return box.force_N() > 0.0; }));
    box.scene->setMuted(true);
    const osg::ref_ptr<Strongest> strongest = new Strongest;
    box.scene->setTouchCallback(strongest);
    for (int i = 0; i < 20; ++i)
        box.frame();
    EXPECT_EQ(strongest->force_N, 0.0) << "callbacks are told the same";
    box.scene->setMuted(false);
    EXPECT_TRUE(box.until([&] { return box.force_N() > 0.0; }));
    EXPECT_GT(strongest->force_N, 0.0);
}

TEST(SilentForce, IsNoneWithoutAnArrayThatPlays)
{
    for (const std::string device : {"record:/nosuch/folder/file", "sim:?drop=1", "nosuch:"})
    {
        PressedBox box(device);
        const osg::ref_ptr<Strongest> strongest = new Strongest;
        box.scene->setTouchCallback(strongest);
        const bool isDeaf = device == "sim:?drop=1";
        ASSERT_TRUE(box.until(
            [&]
            {
                return box.force_N() >= 0.0 &&
                       box.state() == (isDeaf ? ArrayState::FAULT : ArrayState::CLOSED);
            }))
            << device;
        for (int i = 0; i < 20; ++i)
        {
            box.frame();
            EXPECT_EQ(box.force_N(), 0.0) << device;
        }
        if (!isDeaf)
        {
            EXPECT_EQ(strongest->force_N, 0.0) << device << ", from the first frame on";
        }
    }
}

TEST(SilentForce, EndsWithADeviceThatIsLost)
{
    PressedBox box("sim:?unplug_at=500ms");
    ASSERT_TRUE(box.until([&] { return box.force_N() > 0.0; }));
    ASSERT_TRUE(box.until([&] { return box.state() == ArrayState::LOST; }));
    EXPECT_EQ(box.force_N(), 0.0);
    box.frame();
    EXPECT_EQ(box.force_N(), 0.0);
}

TEST(SilentForce, EndsWithTheHoldOfWhatNobodyLeads)
{
    PressedBox box("sim:?hold=100ms");
    ASSERT_TRUE(box.until([&] { return box.force_N() > 0.0; }));
    EXPECT_TRUE(eventually([&] { return box.state() == ArrayState::SILENT; }));
    EXPECT_EQ(box.force_N(), 0.0);
    EXPECT_TRUE(box.until([&] { return box.force_N() > 0.0; })) << "frames come again";
}

TEST(SilentForce, NobodyThereTouchesNothing)
{
    PressedBox box;
    ASSERT_TRUE(box.until([&] { return box.force_N() > 0.0; }));
    box.hands->setHands({});
    EXPECT_TRUE(box.viewer.framesUntil([&] { return box.force_N() < 0.0; }));
}
