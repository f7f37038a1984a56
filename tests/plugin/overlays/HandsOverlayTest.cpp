#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/HandProximity.h"
#include "plugin/overlays/OverlayPart.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace bridge = midair::bridge;

namespace
{

std::vector<bridge::HandCapsule> openHandCapsules()
{
    bridge::HandFrame frame;
    frame.hands = {bridge::openHand(1, Eigen::Isometry3d::Identity())};
    return bridge::handCapsules(frame);
}

bridge::HandContact touch(double force_N)
{
    bridge::HandContact contact;
    contact.object = 3;
    contact.hand = 1;
    contact.bone = 9;
    contact.touching = true;
    contact.position = Eigen::Vector3d(0.01, 0.02, 0.03);
    contact.overlap_m2 = 1e-4;
    contact.force_N = force_N;
    return contact;
}

} // namespace

TEST(HandsOverlay, DrawsBonesAndTouchesAndLetsThemFade)
{
    osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
    bridge::HandContact near = touch(0.0);
    near.touching = false;
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {near}, 1.0);
    EXPECT_EQ(overlay->getNumBones(), bridge::kHandBones);
    EXPECT_EQ(overlay->getNumTouches(), 0); // near is not touched
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {touch(0.0032)}, 1.1);
    ASSERT_EQ(overlay->getNumTouches(), 1);
    EXPECT_EQ(overlay->getLabel(0), bridge::boneName(9) + "  3.20 mN");
    OverlayPart::of(*overlay).setHands(
        openHandCapsules(), {touch(0.0)}, 1.2); // force unknown: no number
    EXPECT_EQ(overlay->getLabel(0), bridge::boneName(9));
    OverlayPart::of(*overlay).setHands({}, {}, 1.6);
    EXPECT_EQ(overlay->getNumBones(), 0);
    EXPECT_EQ(overlay->getNumTouches(), 1); // fading
    OverlayPart::of(*overlay).setHands({}, {}, 1.8);
    EXPECT_EQ(overlay->getNumTouches(), 0);
    OverlayPart::of(*overlay).setHands({}, {touch(0.001)}, 0.1);
    EXPECT_EQ(overlay->getNumTouches(), 1);
    OverlayPart::of(*overlay).setHands({}, {}, 0.0); // the clock was set back
    EXPECT_EQ(overlay->getNumTouches(), 0);
}

/// Under a scene with a hand source the hands come by themselves, in the array's frame.
TEST(HandsOverlay, FollowsTheScenesHands)
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setArray("board");
    scene->setCalibration(osg::Matrix::translate(0.0, 0.0, 0.15)); // world -> array
    osg::ref_ptr<HapticSurface> surface = new HapticSurface;
    surface->setTouchEvents(true);
    surface->addChild(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.04F)));
    scene->addChild(surface);
    osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    scene->addChild(overlays);
    osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    // A finger from above, its tip 2 mm deep.
    hands->setHands(
        {openHand(1, osg::Vec3d(0.0, 0.0, 0.025), osg::Quat(-1.0, osg::Vec3d(1, 0, 0)))});
    scene->setHandSource(hands);
    osgViewer::Viewer viewer;
    viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
    viewer.setSceneData(scene);
    const auto frame = [&](double time_s)
    {
        viewer.advance(time_s);
        viewer.eventTraversal();
        viewer.updateTraversal();
    };
    for (int i = 0; i < 3; ++i)
        frame(0.02 * i);
    EXPECT_EQ(overlays->getHands()->getNumBones(), bridge::kHandBones);
    EXPECT_EQ(overlays->getHands()->getNumTouches(), 1);
    overlays->setShowHands(false); // hidden ones are not brought up to date
    hands->setHands({});
    frame(0.1);
    frame(0.12);
    EXPECT_EQ(overlays->getHands()->getNumBones(), bridge::kHandBones);
    overlays->setShowHands(true);
    frame(0.14);
    EXPECT_EQ(overlays->getHands()->getNumBones(), 0);
}
