#include "samples/installations/shell/Ground.h"

#include "samples/shared/views/Offscreen.h"

#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <string>

#include <gtest/gtest.h>

namespace
{

using namespace midair::samples;

constexpr int kGroundPixels = 200;
constexpr double kSeen_m = 0.1; ///< from the middle to the picture's edge

} // namespace

// The lamp is at (-0.5, -0.7, 0.9): the shadow lies on the other side of the box.
TEST(Ground, LiesUnderWhatStandsOnItAndHasItsShadow)
{
    osgViewer::Viewer viewer;
    std::string problem;
    if (!setUpOffscreen(viewer, kGroundPixels, kGroundPixels, 30.0, &problem))
        GTEST_SKIP() << problem;
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    const osg::ref_ptr<osg::Group> lit = new osg::Group;
    lit->addChild(new osg::ShapeDrawable(new osg::Box({0.0F, 0.0F, 0.12F}, 0.04F)));
    const osg::ref_ptr<osgMidair::HapticOverlays> overlays = new osgMidair::HapticOverlays;
    const Ground ground(*lit, *overlays, 1.0);
    EXPECT_NEAR(ground.height_m(), 0.099, 1e-6);
    EXPECT_EQ(Ground(*lit, *overlays, 0.05).height_m(), 0.05);
    root->addChild(lit);
    root->addChild(ground.node());
    viewer.setSceneData(root);
    osg::Camera& camera = *viewer.getCamera();
    camera.setViewMatrixAsLookAt({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, osg::Y_AXIS);
    camera.setProjectionMatrixAsOrtho(-kSeen_m, kSeen_m, -kSeen_m, kSeen_m, 0.1, 2.0);
    const osg::ref_ptr<FrameGrabber> grabber = new FrameGrabber;
    camera.setFinalDrawCallback(grabber);
    viewer.frame();
    grabber->request();
    viewer.frame();
    ASSERT_TRUE(grabber->image());
    const auto light = [&](double x_m, double y_m)
    {
        const auto pixel = [](double at_m)
        { return static_cast<int>(0.5 * (at_m / kSeen_m + 1.0) * kGroundPixels); };
        return static_cast<int>(grabber->image()->data(pixel(x_m), pixel(y_m))[1]);
    };
    EXPECT_GT(light(-0.03, -0.035), 25);
    EXPECT_LT(light(0.03, 0.035), 0.7 * light(-0.03, -0.035));
}
