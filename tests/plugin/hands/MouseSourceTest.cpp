#include "tests/plugin/KitTest.h"

#include <osgMidair/HandsOverlay>
#include <osgMidair/HapticOverlays>

#include <osgText/Text>

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

TEST(HandsByMouse, FollowTheMouseOfTheViewThatShowsTheScene)
{
    BoxScene box;
    box.scene->setHands("mouse:");
    HeadlessViewer viewer(box.scene);
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0, -0.5, 0), osg::Vec3d(0, 0, 0), osg::Vec3d(0, 0, 1));
    viewer.viewer.getCamera()->setProjectionMatrixAsPerspective(30.0, 1.0, 0.01, 2.0);
    viewer.frames(3);
    EXPECT_EQ(box.scene->getStatistics().hands, 1) << "aside, as the mouse has not moved yet";
    viewer.viewer.getEventQueue()->mouseMotion(0.0F, 0.0F);
    viewer.frames(3);
    EXPECT_EQ(box.scene->getStatistics().hands, 1);
    viewer.viewer.getEventQueue()->keyPress('t');
    viewer.frames(3);
    EXPECT_EQ(box.scene->getStatistics().hands, 0);
    box.scene->setHands("none");
    viewer.viewer.getEventQueue()->mouseMotion(0.1F, 0.1F);
    viewer.frames(3); // the handler in the view has nothing to do any more
    EXPECT_EQ(box.scene->getStatistics().hands, 0);
}

TEST(HandsByMouse, TouchWhatIsUnderTheMouse)
{
    BoxScene box; // 0.15 m over the board, where the camera looks
    box.surface->setTouchEvents(true);
    box.scene->setHands("mouse:");
    HeadlessViewer viewer(box.scene);
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0, -0.5, 0.15), osg::Vec3d(0, 0, 0.15), osg::Vec3d(0, 0, 1));
    viewer.viewer.getCamera()->setProjectionMatrixAsPerspective(30.0, 1.0, 0.01, 2.0);
    viewer.frames(3);
    EXPECT_TRUE(box.scene->getTouches().empty()) << "the hand waits aside";
    EXPECT_EQ(box.scene->getStatistics().hands, 1);
    // The viewer's own queue knows no window: its places go from -1 to 1.
    viewer.viewer.getEventQueue()->mouseMotion(0.0F, 0.0F);
    viewer.frames(3);
    const std::vector<Touch> touches = box.scene->getTouches();
    ASSERT_FALSE(touches.empty());
    EXPECT_EQ(touches[0].path, "HapticScene/MatrixTransform/HapticSurface 'box'");
    EXPECT_TRUE(std::any_of(touches.begin(),
                            touches.end(),
                            [](const Touch& touch) { return touch.finger == Touch::INDEX; }));
    // 0.5 m away the picture is 0.27 m wide, so its edge is 0.13 m from the box's middle.
    viewer.viewer.getEventQueue()->mouseMotion(1.0F, 0.0F);
    viewer.frames(3);
    EXPECT_EQ(box.scene->getStatistics().hands, 1);
    for (const Touch& touch : box.scene->getTouches())
        EXPECT_NE(touch.finger, Touch::INDEX);
}

TEST(HandsByMouse, TheWheelsDepthIsShownBesideTheHand)
{
    BoxScene box;
    box.scene->setHands("mouse:");
    const osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    box.scene->addChild(overlays);
    HeadlessViewer viewer(box.scene);
    viewer.viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0, -0.5, 0.15), osg::Vec3d(0, 0, 0.15), osg::Vec3d(0, 0, 1));
    viewer.viewer.getCamera()->setProjectionMatrixAsPerspective(30.0, 1.0, 0.01, 2.0);
    const auto isSaid = [&](const std::string& text)
    {
        const HandsOverlay& hands = *overlays->get<HandsOverlay>();
        const osg::Group& labels = *hands.getChild(hands.getNumChildren() - 1)->asGroup();
        for (unsigned int i = 0; i < labels.getNumChildren(); ++i)
            if (auto* label = dynamic_cast<const osgText::Text*>(labels.getChild(i)))
                if (label->getText().createUTF8EncodedString().find(text) != std::string::npos)
                    return true;
        return false;
    };
    const auto wheel = [&](osgGA::GUIEventAdapter::ScrollingMotion motion, int steps)
    {
        osgGA::EventQueue& queue = *viewer.viewer.getEventQueue();
        queue.getCurrentEventState()->setModKeyMask(osgGA::GUIEventAdapter::MODKEY_CTRL);
        for (int i = 0; i < steps; ++i)
            queue.mouseScroll(motion);
        viewer.frames(3);
    };
    viewer.frames(3);
    EXPECT_FALSE(isSaid("middle")) << "the wheel hasn't been used";
    wheel(osgGA::GUIEventAdapter::SCROLL_UP, 12);
    EXPECT_TRUE(isSaid("24 mm behind the middle"));
    wheel(osgGA::GUIEventAdapter::SCROLL_DOWN, 12);
    EXPECT_TRUE(isSaid("in the middle"));
    wheel(osgGA::GUIEventAdapter::SCROLL_DOWN, 3);
    EXPECT_TRUE(isSaid("6 mm before the middle"));
}

TEST(HandsByMouse, SayOnceThatThereIsNoViewer)
{
    BoxScene box;
    box.scene->setHands("mouse:");
    for (unsigned int frame = 0; frame < 200; ++frame)
        box.scene->update(nullptr);
    const std::vector<HapticMessage> told = box.scene->getStatistics().told;
    const auto found =
        std::find_if(told.begin(),
                     told.end(),
                     [](const HapticMessage& message) { return message.code == "hands.source"; });
    ASSERT_NE(found, told.end());
    EXPECT_EQ(found->text,
              "hand source \"mouse:\": there is no viewer whose mouse it can follow, so there is "
              "no hand");
    EXPECT_EQ(found->count, 1u);
}
