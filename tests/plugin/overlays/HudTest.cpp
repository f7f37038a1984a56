#include "samples/shared/views/Offscreen.h"
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/Hud>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace samples = midair::samples;

namespace
{

constexpr int kWidth = 640;
constexpr int kHeight = 480;

/// A scene that plays, seen off screen from far away: of all but the overlays' letters nothing is
/// drawn on white.
class SceneView
{
public:
    SceneView() : overlays(new HapticOverlays), _grabber(new samples::FrameGrabber)
    {
        overlays->setShowAll(false);
        overlays->get<Hud>()->setUpdateInterval(0.0);
        overlays->get<Hud>()->setKeyTime(0.0);
        box.scene->addChild(overlays);
        able = samples::setUpOffscreen(viewer, kWidth, kHeight, 30.0, &problem);
        if (!able) return;
        viewer.getCamera()->setClearColor({1.0F, 1.0F, 1.0F, 1.0F});
        viewer.getCamera()->setViewMatrixAsLookAt(
            {0.0, 0.0, 900.0}, {0.0, 0.0, 901.0}, {0.0, 1.0, 0.0});
        viewer.getCamera()->setFinalDrawCallback(_grabber);
        viewer.setSceneData(box.scene);
    }

    void frame()
    {
        _time_s += 0.1;
        viewer.frame(_time_s);
    }
    /// Runs frames until the array is in \a state and its figures are there.
    bool framesUntil(ArrayState state)
    {
        const auto isThere = [&]
        {
            const HapticStatistics now = box.scene->getStatistics();
            return now.state == state && now.processed >= now.snapshots;
        };
        eventually(
            [&]
            {
                if (isThere()) return true;
                frame();
                return false;
            });
        frame();
        return isThere();
    }
    void press(int key)
    {
        viewer.getEventQueue()->keyPress(key);
        frame();
    }
    /// Number of pixels in the upper or the lower half of a picture, from \a column on, that are
    /// not white.
    int drawn(bool upper, int column = 0)
    {
        frame();
        _grabber->request();
        frame();
        int count = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = column; x < kWidth; ++x)
                if ((y >= kHeight / 2) == upper && _grabber->image()->data(x, y)[1] < 250) ++count;
        return count;
    }
    void wait(double time_s) { _time_s += time_s; }

    BoxScene box;
    osgViewer::Viewer viewer;
    osg::ref_ptr<HapticOverlays> overlays;
    bool able = false;
    std::string problem;

private:
    osg::ref_ptr<samples::FrameGrabber> _grabber;
    double _time_s = 0.0;
};

using Keys = osgGA::GUIEventAdapter;

} // namespace

TEST(Hud, MutedIsSeenWhateverIsHidden)
{
    SceneView view;
    if (!view.able) GTEST_SKIP() << view.problem;
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING));
    EXPECT_EQ(view.drawn(true), 0);
    EXPECT_EQ(view.drawn(false), 0);
    view.press(Keys::KEY_F8);
    EXPECT_GT(view.drawn(true), kWidth * kHeight / 40) << "in large letters, in the next frame";
    view.press(Keys::KEY_F8);
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING)) << "MUTED stays until the array plays";
    EXPECT_EQ(view.drawn(true), 0);
}

TEST(Hud, CappedIsSaidWithTheFigures)
{
    SceneView view;
    if (!view.able) GTEST_SKIP() << view.problem;
    view.box.surface->setPressureUnit(HapticProperty::PASCAL);
    view.box.surface->setPressure(2000.0);
    view.box.scene->setMaxPressure(400.0);
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING));
    EXPECT_LT(view.box.scene->getStatistics().capFactor, 1.0);
    EXPECT_EQ(view.drawn(true), 0);
    view.overlays->setShown("figures", true);
    EXPECT_GT(view.drawn(true), kWidth * kHeight / 40);
    EXPECT_GT(view.drawn(false), kWidth * kHeight / 40);
    EXPECT_EQ(view.drawn(true, kWidth / 2), 0) << "beside what is touched, not over it";
}

TEST(Hud, PlainOnesDrawNothingButMuted)
{
    SceneView view;
    if (!view.able) GTEST_SKIP() << view.problem;
    view.overlays->setShowAll(true);
    EXPECT_TRUE(view.overlays->setNumber("plain", 1.0));
    EXPECT_TRUE(view.overlays->get<Hud>()->getPlain());
    view.overlays->get<Hud>()->setKeyTime(1e3);
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING));
    EXPECT_EQ(view.drawn(true) + view.drawn(false), 0);
    view.press(Keys::KEY_F7); // hides nothing, as nothing is seen
    EXPECT_TRUE(view.overlays->isShown("array"));
    EXPECT_EQ(view.drawn(true) + view.drawn(false), 0);
    view.press(Keys::KEY_F8);
    EXPECT_GT(view.drawn(true), kWidth * kHeight / 40);
    EXPECT_EQ(view.drawn(false), 0);
}

TEST(Hud, KeysAreListedAtTheStartAndAfterOneOfThem)
{
    SceneView view;
    if (!view.able) GTEST_SKIP() << view.problem;
    view.overlays->get<Hud>()->setKeyTime(8.0);
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING));
    view.wait(9.0);
    EXPECT_EQ(view.drawn(true), 0);
    view.press(Keys::KEY_F10); // hands, of which there are none
    EXPECT_GT(view.drawn(true), 2000);
    view.wait(9.0);
    EXPECT_EQ(view.drawn(true), 0);
    view.overlays->get<Hud>()->setKeyTime(0.0);
    view.press(Keys::KEY_F10);
    EXPECT_EQ(view.drawn(true), 0);
}

// The list that F7 shows for a while is the same one.
TEST(Hud, F1KeepsTheKeysThatAnotherKeyHasListed)
{
    SceneView view;
    if (!view.able) GTEST_SKIP() << view.problem;
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING));
    view.overlays->get<Hud>()->setKeyTime(8.0);
    view.press(Keys::KEY_F10);
    view.press(Keys::KEY_F1);
    EXPECT_GT(view.drawn(true), 2000);
    view.wait(1e3);
    EXPECT_GT(view.drawn(true), 2000);
    view.press(Keys::KEY_F1);
    EXPECT_EQ(view.drawn(true), 0);
}

TEST(Hud, F1ListsTheKeysUntilItIsPressedAgain)
{
    SceneView view;
    if (!view.able) GTEST_SKIP() << view.problem;
    ASSERT_TRUE(view.framesUntil(ArrayState::PLAYING));
    view.press(Keys::KEY_F1);
    EXPECT_GT(view.drawn(true), 2000);
    view.wait(1e3);
    const int listed = view.drawn(true);
    EXPECT_GT(listed, 2000);
    // The camera looks away from all of it.
    for (const char* each : {"points", "slice", "array", "workspace"})
        view.overlays->setShown(each, true);
    EXPECT_GT(view.drawn(true), listed) << "what isn't in sight says so";
    view.press(Keys::KEY_F1);
    EXPECT_EQ(view.drawn(true), 0);
}
