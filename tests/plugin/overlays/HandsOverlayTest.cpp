#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/HandProximity.h"
#include "plugin/overlays/OverlayPart.h"
#include "samples/shared/views/Offscreen.h"

#include <osgMidair/HandsOverlay>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgText/Text>
#include <osgViewer/Viewer>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <vector>

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
    contact.finger = bridge::INDEX;
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
    EXPECT_EQ(overlay->getLabel(0), "index 3.2 mN");
    OverlayPart::of(*overlay).setHands(
        openHandCapsules(), {touch(0.0)}, 1.2); // force unknown: no number
    EXPECT_EQ(overlay->getLabel(0), "index");
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

TEST(HandsOverlay, EachFingerHasOneLabelAndNoneIsOverAnother)
{
    osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
    bridge::HandContact index = touch(0.004);
    bridge::HandContact other = touch(0.005); // of the same finger, at another object
    other.object = 4;
    bridge::HandContact thumb = touch(0.0123);
    thumb.finger = bridge::THUMB;
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {index, other, thumb}, 1.0);
    ASSERT_EQ(overlay->getNumTouches(), 3);
    EXPECT_EQ(overlay->getLabel(0), "index 9.0 mN");
    EXPECT_EQ(overlay->getLabel(1), "");
    EXPECT_EQ(overlay->getLabel(2), "thumb 12 mN");
    std::vector<std::string> texts;
    std::set<osg::Vec3> places;
    const osg::Group& labels = *overlay->getChild(overlay->getNumChildren() - 1)->asGroup();
    for (unsigned int i = 0; i < labels.getNumChildren(); ++i)
        if (auto* label = dynamic_cast<const osgText::Text*>(labels.getChild(i)))
            if (!label->getText().empty())
            {
                texts.push_back(label->getText().createUTF8EncodedString());
                places.insert(label->getPosition());
            }
    EXPECT_EQ(places.size(), 1U) << "lines of one text, wherever the eye is";
    EXPECT_EQ(texts, (std::vector<std::string>{"\nindex 9.0 mN", "thumb 12 mN"}));
}

/// A label is as high near the eye as far from it, and larger on a large screen alone.
TEST(HandsOverlay, LabelsStaySmall)
{
    const auto heightOf = [](int pixels, double distance_m, std::string& problem)
    {
        osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
        osgViewer::Viewer viewer;
        if (!midair::samples::setUpOffscreen(viewer, pixels, pixels, 30.0, &problem)) return 0;
        const osg::ref_ptr<midair::samples::FrameGrabber> grabber =
            new midair::samples::FrameGrabber;
        osg::Camera& camera = *viewer.getCamera();
        camera.setClearColor({1.0F, 1.0F, 1.0F, 1.0F});
        camera.setViewMatrixAsLookAt(
            {0.01, 0.02 - distance_m, 0.03}, {0.01, 0.02, 0.03}, {0.0, 0.0, 1.0});
        camera.setFinalDrawCallback(grabber);
        viewer.setSceneData(overlay);
        for (int frame = 0; frame < 3; ++frame)
        {
            OverlayPart::of(*overlay).setHands({}, {touch(0.0032)}, 1.0);
            if (frame == 2) grabber->request();
            viewer.frame();
        }
        // Right of the ring, whose radius is 5.6 mm; the label begins 2 mm beyond it.
        const double pixel_m = 2.0 * distance_m * 0.268 / pixels;
        const int beyond = pixels / 2 + static_cast<int>(7.6e-3 / pixel_m);
        int low = pixels;
        int high = -1;
        for (int y = 0; y < pixels; ++y)
            for (int x = beyond; x < pixels; ++x)
                if (grabber->image()->data(x, y)[2] < 200)
                {
                    low = std::min(low, y);
                    high = std::max(high, y);
                }
        return high - low + 1;
    };
    std::string problem;
    const int near = heightOf(600, 0.08, problem);
    if (!problem.empty()) GTEST_SKIP() << problem;
    EXPECT_GE(near, 13);
    EXPECT_LE(near, 30);
    EXPECT_NEAR(heightOf(600, 0.8, problem), near, 2);
    EXPECT_NEAR(heightOf(2160, 0.3, problem), 1620.0 / 560.0 * near, 7) << "follows the window";
}

namespace
{

/// The rings of \a overlay, three corners each.
const osg::Vec3Array& ringsOf(const HandsOverlay& overlay)
{
    return static_cast<const osg::Vec3Array&>(
        *overlay.getChild(overlay.getNumChildren() - 2)->asGeometry()->getVertexArray());
}

/// The labels of \a overlay that are not empty.
std::vector<std::string> labelsOf(const HandsOverlay& overlay)
{
    std::vector<std::string> texts;
    const osg::Group& labels = *overlay.getChild(overlay.getNumChildren() - 1)->asGroup();
    for (unsigned int i = 0; i < labels.getNumChildren(); ++i)
        if (auto* label = dynamic_cast<const osgText::Text*>(labels.getChild(i)))
            if (!label->getText().empty())
                texts.push_back(label->getText().createUTF8EncodedString());
    return texts;
}

} // namespace

TEST(HandsOverlay, ARingGoesWhenNothingIsPlayed)
{
    osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {touch(0.0)}, 1.0);
    EXPECT_EQ(ringsOf(*overlay).size(), 0U) << "nothing has been felt yet";
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {touch(0.003)}, 1.1);
    EXPECT_EQ(ringsOf(*overlay).size(), 3U);
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {touch(0.0)}, 1.2); // muted
    EXPECT_EQ(ringsOf(*overlay).size(), 3U) << "fades";
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {touch(0.0)}, 1.7);
    EXPECT_EQ(ringsOf(*overlay).size(), 0U);
    EXPECT_EQ(overlay->getNumTouches(), 1) << "the finger touches all the same";
    EXPECT_EQ(labelsOf(*overlay), std::vector<std::string>{"index"});
}

TEST(HandsOverlay, ARingIsAroundTheFingerAndNotBelowIt)
{
    osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
    const std::vector<bridge::HandCapsule> hand = openHandCapsules();
    const auto bone = std::find_if(
        hand.begin(), hand.end(), [](const bridge::HandCapsule& one) { return one.bone == 9; });
    ASSERT_NE(bone, hand.end());
    bridge::HandContact contact = touch(0.003);
    // On the object under the fingertip, beyond its end.
    const Eigen::Vector3d along = (bone->shape.b - bone->shape.a).normalized();
    contact.position = bone->shape.b + 0.002 * along - Eigen::Vector3d(0.0, 0.007, 0.0);
    OverlayPart::of(*overlay).setHands(hand, {contact}, 1.0);
    ASSERT_EQ(ringsOf(*overlay).size(), 3U);
    const osg::Vec3 tip(static_cast<float>(bone->shape.b.x()),
                        static_cast<float>(bone->shape.b.y()),
                        static_cast<float>(bone->shape.b.z()));
    EXPECT_LT((ringsOf(*overlay)[0] - tip).length(), 1e-4);
}

TEST(HandsOverlay, ANoteIsBesideTheFirstHandBelowItsTouches)
{
    osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
    OverlayPart::of(*overlay).setHandNote("24 mm behind the middle");
    OverlayPart::of(*overlay).setHands({}, {}, 1.0);
    EXPECT_TRUE(labelsOf(*overlay).empty()) << "there is no hand";
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {}, 1.1);
    EXPECT_EQ(labelsOf(*overlay), std::vector<std::string>{"24 mm behind the middle"});
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {touch(0.003)}, 1.2);
    EXPECT_EQ(labelsOf(*overlay),
              (std::vector<std::string>{"\n24 mm behind the middle", "index 3.0 mN"}));
    OverlayPart::of(*overlay).setHandNote({});
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {}, 2.0);
    EXPECT_TRUE(labelsOf(*overlay).empty());
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
    // A hand from above, the tip of its index finger 2 mm deep; so is that of the middle finger.
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
    EXPECT_EQ(overlays->get<HandsOverlay>()->getNumBones(), bridge::kHandBones);
    EXPECT_EQ(overlays->get<HandsOverlay>()->getNumTouches(), 2);
    overlays->setShown("hands", false); // hidden ones are not brought up to date
    hands->setHands({});
    frame(0.1);
    frame(0.12);
    EXPECT_EQ(overlays->get<HandsOverlay>()->getNumBones(), bridge::kHandBones);
    overlays->setShown("hands", true);
    frame(0.14);
    EXPECT_EQ(overlays->get<HandsOverlay>()->getNumBones(), 0);
}

namespace
{

using midair::samples::FrameGrabber;

/// A red ball on a line from the eye, which is 0.5 m over the back of a flat hand, through a finger
/// or beside it. The window's background is green.
struct BallAndHand
{
    /// \a above_m: the finger's middle; its radius is 8 mm.
    explicit BallAndHand(double above_m, const std::function<void(HandsOverlay&)>& arrange = {})
    {
        bridge::HandFrame frame;
        frame.hands = {bridge::openHand(1, Eigen::Isometry3d::Identity())};
        const Eigen::Vector3d on = frame.hands[0].joints[bridge::INDEX_DISTAL].position;
        const osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
        if (arrange) arrange(*overlay);
        OverlayPart::of(*overlay).setHands(bridge::handCapsules(frame), {}, 0.0);
        osg::ref_ptr<osg::Group> root = new osg::Group;
        const osg::ref_ptr<osg::ShapeDrawable> ball =
            new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(static_cast<float>(on.x()),
                                                             static_cast<float>(above_m),
                                                             static_cast<float>(on.z())),
                                                   0.003F));
        ball->setColor({1.0F, 0.0F, 0.0F, 1.0F});
        ball->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
        root->addChild(ball);
        root->addChild(overlay);
        osgViewer::Viewer viewer;
        std::string problem;
        if (!midair::samples::setUpOffscreen(viewer, kSide, kSide, 3.0, &problem)) return;
        const osg::ref_ptr<FrameGrabber> grabber = new FrameGrabber;
        osg::Camera& camera = *viewer.getCamera();
        camera.setClearColor({0.0F, 1.0F, 0.0F, 1.0F});
        camera.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
        camera.setProjectionMatrixAsPerspective(3.0, 1.0, 0.05, 2.0);
        camera.setViewMatrixAsLookAt(
            {on.x(), 0.5, on.z()}, {on.x(), 0.0, on.z()}, {0.0, 0.0, -1.0});
        camera.setFinalDrawCallback(grabber);
        viewer.setSceneData(root);
        viewer.frame();
        grabber->request();
        viewer.frame();
        image = grabber->image();
    }
    osg::Vec3ub at(int x, int y) const
    {
        const unsigned char* pixel = image->data(x, y);
        return {pixel[0], pixel[1], pixel[2]};
    }
    osg::Vec3ub middle() const { return at(kSide / 2, kSide / 2); }

    static constexpr int kSide = 100; ///< pixels; of 26 mm
    osg::ref_ptr<osg::Image> image;
};

const osg::Vec3ub kRed(255, 0, 0);
const osg::Vec3ub kBlack(0, 0, 0);

} // namespace

TEST(HandsOverlay, HidesWhatIsBehindAFinger)
{
    if (!BallAndHand(0.0).image) GTEST_SKIP() << "no OpenGL";
    const osg::Vec3ub skin = BallAndHand(-0.03).middle();
    EXPECT_NE(skin, kRed) << "behind";
    EXPECT_GT(skin.r(), skin.b()) << "looks like skin";
    EXPECT_GT(skin.r(), 60);
    EXPECT_EQ(BallAndHand(0.03).middle(), kRed) << "before it";
    const auto occlude = [](HandsOverlay& overlay) { overlay.setOcclude(true); };
    EXPECT_EQ(BallAndHand(-0.03, occlude).middle(), kBlack) << "behind";
    EXPECT_EQ(BallAndHand(0.03, occlude).middle(), kRed) << "before it";
    const auto capsules = [](HandsOverlay& overlay)
    {
        overlay.setCapsules(true);
        overlay.setOcclude(true);
    };
    EXPECT_EQ(BallAndHand(-0.03, capsules).middle(), kBlack) << "behind";
    EXPECT_EQ(BallAndHand(0.03, capsules).middle(), kRed) << "before it";
}

/// What is only one finger of a tracker has no palm.
TEST(HandsOverlay, DrawsCapsulesOfAHandWithoutAPalm)
{
    osg::ref_ptr<HandsOverlay> overlay = new HandsOverlay;
    std::vector<bridge::HandCapsule> finger = openHandCapsules();
    finger.resize(8);
    finger.erase(finger.begin(), finger.begin() + 6);
    const unsigned int before = overlay->getNumChildren();
    OverlayPart::of(*overlay).setHands(finger, {}, 0.0);
    EXPECT_EQ(overlay->getNumBones(), 2);
    const auto capsules = [&overlay]
    {
        return overlay->getChild(overlay->getNumChildren() - 3)
            ->asGeometry()
            ->getVertexArray()
            ->getNumElements();
    };
    EXPECT_EQ(capsules(), 8U);
    OverlayPart::of(*overlay).setHands(openHandCapsules(), {}, 0.1);
    EXPECT_EQ(capsules(), 0U);
    EXPECT_EQ(overlay->getChild(0)->getNodeMask(), ~0U) << "the skin";
    OverlayPart::of(*overlay).setHands({}, {}, 0.2);
    EXPECT_EQ(overlay->getChild(0)->getNodeMask(), 0U);
    EXPECT_LE(overlay->getNumChildren(), before + 1);
}
