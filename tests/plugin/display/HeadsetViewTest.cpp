// A headset of the tests' runtime, by GLX in a display in memory: each eye's picture, and how far
// the pose that it was drawn for was from the eye's when it was displayed.
#include "engine-bridge/scene/Convert.h"
#include "tests/Eventually.h"
#include "tests/Xvfb.h"
#include "tests/fake-openxr/FakeHands.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HandSource>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticStatistics>
#include <osgMidair/HapticSurface>
#include <osgMidair/HeadsetView>
#include <osgMidair/Hud>
#include <osgMidair/XrSession>

#include <osg/Geometry>
#include <osgGA/OrbitManipulator>
#include <osgViewer/Viewer>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace osgMidair
{

namespace
{

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHeadSpeed = 0.5; ///< m/s, of the head

/// From the scene's world to the runtime's space: z up to y up.
Vector3d inSpace(const Vector3d& world)
{
    return {world.x(), world.z(), -world.y()};
}

/// The pixel at which an eye of \a pose sees \a at, by the angles to it.
Vector2d eyePixelOf(const FakePicture& picture, const XrPosef& pose, const Vector3d& at)
{
    const XrVector3f& p = pose.position;
    const XrQuaternionf& q = pose.orientation;
    const Vector3d to =
        Eigen::Quaterniond(q.w, q.x, q.y, q.z).inverse() * (inSpace(at) - Vector3d(p.x, p.y, p.z));
    const auto share = [](double tangent, double from, double end)
    { return (tangent - std::tan(from)) / (std::tan(end) - std::tan(from)); };
    return {picture.width * share(to.x() / -to.z(), picture.fov.angleLeft, picture.fov.angleRight),
            picture.height * share(to.y() / -to.z(), picture.fov.angleDown, picture.fov.angleUp)};
}

const std::array<Vector3d, 4> kFaceCorners = {Vector3d(-0.03, 0.0, 0.12),
                                              Vector3d(0.03, 0.0, 0.12),
                                              Vector3d(0.03, 0.0, 0.18),
                                              Vector3d(-0.03, 0.0, 0.18)};

/// A white face that looks to -y, where the head is.
osg::ref_ptr<osg::Geometry> whiteFace()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    const osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const Vector3d& corner : kFaceCorners)
        vertices->push_back(osg::Vec3(midair::bridge::toOsg(corner)));
    const osg::Vec4 white(1.0F, 1.0F, 1.0F, 1.0F);
    geometry->setVertexArray(vertices);
    geometry->setColorArray(new osg::Vec4Array(1, &white), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_FAN, 0, 4));
    geometry->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    return geometry;
}

bool isInFace(const std::array<Vector2d, 4>& polygon, const Vector2d& at)
{
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        const Vector2d a = polygon[i] - at;
        const Vector2d b = polygon[(i + 1) % polygon.size()] - at;
        if (a.x() * b.y() - a.y() * b.x() < 0.0) return false;
    }
    return true;
}

struct BrightSpot
{
    double count = 0.0;
    Vector2d middle = Vector2d::Zero();

    void add(int x, int y)
    {
        count += 1.0;
        middle += Vector2d(x + 0.5, y + 0.5);
    }
    Vector2d at() const { return middle / std::max(1.0, count); }
};

/// Where the picture is bright.
BrightSpot brightOf(const FakePicture& picture)
{
    BrightSpot spot;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            if (picture.rgba[4 * static_cast<std::size_t>(y * picture.width + x)] > 127)
                spot.add(x, y);
    return spot;
}

BrightSpot expectedOf(const FakePicture& picture, const XrPosef& pose)
{
    std::array<Vector2d, 4> corners;
    for (std::size_t i = 0; i < corners.size(); ++i)
        corners[i] = eyePixelOf(picture, pose, kFaceCorners[i]);
    BrightSpot spot;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            if (isInFace(corners, {x + 0.5, y + 0.5})) spot.add(x, y);
    return spot;
}

struct Headset : testing::Test
{
    void SetUp() override
    {
        if (!useXvfb()) GTEST_SKIP() << "there is no Xvfb";
        useFakeRuntime();
        const FakeAccess fake;
        fake->extensions = {"XR_EXT_hand_tracking",
                            "XR_KHR_convert_timespec_time",
                            "XR_KHR_opengl_enable",
                            "XR_KHR_composition_layer_depth",
                            "XR_FB_passthrough"};
        // 0.4 m before the face, as a head that looks at it.
        fake->head = XrPosef{{0.0F, 0.0F, 0.0F, 1.0F}, {0.02F, 0.2F, 0.4F}};
        fake->start = FakeState::now();
    }

    void TearDown() override
    {
        headset = nullptr;
        viewer.reset();
        XrSession::getRecentred();
        const FakeAccess fake;
        EXPECT_EQ(fake->misuse, std::vector<std::string>());
        EXPECT_EQ(fake->alive, 0);
    }

    /// \a cullMask: of the viewer's camera, and so of the eyes'.
    void show(osg::Node* root, osg::Node::NodeMask cullMask = ~0U)
    {
        viewer = std::make_unique<osgViewer::Viewer>();
        viewer->setUpViewInWindow(0, 0, 160, 120);
        viewer->setLightingMode(osg::View::NO_LIGHT);
        viewer->getCamera()->setClearColor(osg::Vec4(0.1F, 0.1F, 0.1F, 1.0F));
        viewer->getCamera()->setCullMask(cullMask);
        viewer->setSceneData(root);
        std::string error;
        headset = HeadsetView::open("openxr:", error);
        ASSERT_TRUE(headset) << error;
        ASSERT_TRUE(headset->attach(*viewer, error)) << error;
        viewer->realize();
        ASSERT_TRUE(viewer->isRealized());
    }

    bool framesUntil(const std::function<bool()>& done)
    {
        if (!viewer || !viewer->isRealized()) return false;
        return eventually(
            [&]
            {
                viewer->frame();
                return done();
            });
    }

    bool drawn(int more = 3)
    {
        const int before = FakeAccess()->framesDrawn;
        return framesUntil([&] { return FakeAccess()->framesDrawn >= before + more; });
    }

    bool says(const std::string& text) const
    {
        const std::vector<std::string> all = headset->getMessages();
        return std::any_of(all.begin(),
                           all.end(),
                           [&](const std::string& one)
                           { return one.find(text) != std::string::npos; });
    }

    std::unique_ptr<osgViewer::Viewer> viewer;
    osg::ref_ptr<HeadsetView> headset;
};

TEST_F(Headset, EachEyeSeesTheSceneFromWhereItIsWhenTheFrameIsDisplayed)
{
    FakeAccess()->speed = {static_cast<float>(kHeadSpeed), 0.0F, 0.0F};
    show(whiteFace());
    ASSERT_TRUE(drawn(20));
    EXPECT_TRUE(headset->isRunning());
    const FakeAccess fake;
    EXPECT_LE(fake->largestOff_m, 1e-3);
    for (const FakePicture& picture : fake->pictures)
    {
        const BrightSpot seen = brightOf(picture);
        const BrightSpot expected = expectedOf(picture, picture.truePose);
        ASSERT_GT(expected.count, 200.0);
        EXPECT_LE((seen.at() - expected.at()).norm(), 0.5);
        EXPECT_NEAR(seen.count, expected.count, 0.05 * expected.count);
        EXPECT_LE(picture.off_m, 1e-3);
        EXPECT_LE(picture.off_rad, 1e-3);
    }
    RecordProperty("off_mm", std::to_string(1e3 * fake->largestOff_m));
}

TEST_F(Headset, TheDepthIsHandedOver)
{
    show(whiteFace());
    ASSERT_TRUE(drawn());
    const FakeAccess fake;
    for (const FakePicture& picture : fake->pictures)
    {
        ASSERT_FALSE(picture.depth.empty());
        const Vector2d at = eyePixelOf(picture, picture.truePose, Vector3d(0.0, 0.0, 0.15));
        const float depth = picture.depth[static_cast<std::size_t>(
            static_cast<int>(at.y()) * picture.width + static_cast<int>(at.x()))];
        // 0.4 m ahead, but for the eye's cant; near 0.02 m, far 20 m.
        const double z_m = 20.0 * 0.02 / (20.0 - depth * (20.0 - 0.02));
        EXPECT_NEAR(z_m, 0.4, 0.01);
    }
}

TEST_F(Headset, TheRoomIsSeenBehindWhatIsDrawn)
{
    FakeAccess()->blendModes = {XR_ENVIRONMENT_BLEND_MODE_ADDITIVE,
                                XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    show(whiteFace());
    ASSERT_TRUE(drawn());
    {
        const FakeAccess fake;
        EXPECT_EQ(fake->blend, XR_ENVIRONMENT_BLEND_MODE_ADDITIVE);
        const unsigned char* corner = fake->pictures[0].rgba.data();
        EXPECT_EQ(corner[0] + corner[1] + corner[2], 0) << "light that is added to the room's";
    }
    headset = nullptr;
    viewer.reset();
    FakeAccess()->blendModes = {XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    FakeAccess()->hasPassthrough = true;
    show(whiteFace());
    ASSERT_TRUE(drawn());
    const FakeAccess fake;
    EXPECT_EQ(fake->blend, XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
    EXPECT_EQ(fake->roomLayers, 1);
    EXPECT_NE(fake->layerFlags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT, 0U);
    EXPECT_EQ(fake->pictures[0].rgba[3], 0);
}

// A picture that is added to the room's light would shine over the finger before the face. The
// scene comes after the headset.
TEST_F(Headset, NothingIsDrawnBehindAFingerWhereTheRoomIsSeen)
{
    FakeAccess()->blendModes = {XR_ENVIRONMENT_BLEND_MODE_ADDITIVE};
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(whiteFace());
    show(root);
    ASSERT_TRUE(drawn());
    const osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setArray("board");
    const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    hands->setHands({openHand(1, {0.0, -0.02, 0.15}, {})});
    scene->setHandSource(hands);
    root->addChild(scene);
    const auto light = [](int eye, const Vector3d& at)
    {
        const FakeAccess fake;
        const FakePicture& picture = fake->pictures[static_cast<std::size_t>(eye)];
        const Vector2d pixel = eyePixelOf(picture, picture.truePose, at);
        return static_cast<int>(
            picture.rgba[4 * static_cast<std::size_t>(static_cast<int>(pixel.y()) * picture.width +
                                                      static_cast<int>(pixel.x()))]);
    };
    const Vector3d tip(0.0, -0.02, 0.148);
    EXPECT_TRUE(framesUntil([&] { return light(0, tip) == 0 && light(1, tip) == 0; }));
    EXPECT_GT(light(0, {0.025, 0.0, 0.125}), 127) << "beside the finger there is the face";
}

// A moving scene is told when its light is seen, and that nobody knows how far off that is.
TEST_F(Headset, TheSceneKnowsWhenAndByWhomItIsSeen)
{
    const osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setArray("board");
    const osg::ref_ptr<HapticSurface> surface = new HapticSurface;
    surface->addChild(whiteFace());
    scene->addChild(surface);
    show(scene);
    const auto unknown = [&]
    {
        const auto all = scene->getStatistics().coincidence;
        return all.empty() ? std::string() : all.front().unknown;
    };
    EXPECT_TRUE(framesUntil([&] { return unknown().find("not measured") != std::string::npos; }))
        << unknown();
}

TEST_F(Headset, AManipulatorIsTakenAway)
{
    show(whiteFace());
    viewer->setCameraManipulator(new osgGA::OrbitManipulator);
    ASSERT_TRUE(drawn());
    EXPECT_FALSE(viewer->getCameraManipulator());
    EXPECT_TRUE(says("the viewer's camera manipulator is removed"));
}

TEST_F(Headset, AStoppedSessionGoesOn)
{
    show(whiteFace());
    ASSERT_TRUE(drawn());
    FakeAccess()->states = {XR_SESSION_STATE_STOPPING, XR_SESSION_STATE_IDLE};
    ASSERT_TRUE(framesUntil([&] { return !headset->isRunning(); }));
    EXPECT_NE(viewer->getCamera()->getCullMask(), 0U) << "the window shows the scene";
    EXPECT_TRUE(says("openxr: Fake XR 1.2.3 stopped the session; no picture in a headset until it "
                     "goes on"));
    FakeAccess()->states = {XR_SESSION_STATE_READY};
    EXPECT_TRUE(drawn());
    EXPECT_EQ(FakeAccess()->begun, 2);
}

TEST_F(Headset, ALostSessionIsFoundAgain)
{
    show(whiteFace());
    ASSERT_TRUE(drawn());
    FakeAccess()->states = {XR_SESSION_STATE_LOSS_PENDING};
    ASSERT_TRUE(framesUntil(
        [&] { return says("loses the session; no picture in a headset until it is back"); }));
    EXPECT_TRUE(framesUntil([] { return FakeAccess()->begun == 2; }));
    EXPECT_TRUE(drawn());
    EXPECT_EQ(FakeAccess()->instances, 2);
}

TEST_F(Headset, ASessionThatTheUserEndedStaysEnded)
{
    show(whiteFace());
    ASSERT_TRUE(drawn());
    FakeAccess()->states = {XR_SESSION_STATE_STOPPING, XR_SESSION_STATE_EXITING};
    ASSERT_TRUE(framesUntil([&] { return says("ended the session"); }));
    for (int i = 0; i < 20; ++i)
        viewer->frame();
    EXPECT_EQ(FakeAccess()->instances, 1);
    EXPECT_FALSE(headset->isRunning());
}

TEST_F(Headset, HandsAreOfTheSameInstance)
{
    BoxScene box;
    box.scene->setHands("openxr:");
    show(box.scene);
    FakeAccess()->hands[1] = fakeHand(midair::bridge::openHandWithIndexTipAt(
        1, Vector3d(0.0, 0.3, 0.1), Eigen::Quaterniond::Identity()));
    EXPECT_TRUE(framesUntil([&] { return box.scene->getStatistics().hands == 1; }));
    EXPECT_EQ(FakeAccess()->instances, 1);
}

TEST_F(Headset, TheMenusButtonMutes)
{
    BoxScene box;
    show(box.scene);
    ASSERT_TRUE(drawn());
    EXPECT_FALSE(box.scene->getMuted());
    FakeAccess()->isMutePressed = true;
    EXPECT_TRUE(framesUntil([&] { return box.scene->getMuted(); }));
    FakeAccess()->isMutePressed = false;
    ASSERT_TRUE(drawn());
    EXPECT_TRUE(box.scene->getMuted());
    FakeAccess()->isMutePressed = true;
    EXPECT_TRUE(framesUntil([&] { return !box.scene->getMuted(); }));
}

TEST_F(Headset, AMovedSpaceIsTold)
{
    BoxScene box;
    show(box.scene);
    ASSERT_TRUE(drawn());
    FakeAccess()->otherEvent = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
    const std::string why = "openxr: Fake XR 1.2.3 moves the origin of its stage space: the "
                            "calibration of hands is no longer valid";
    ASSERT_TRUE(framesUntil([&] { return XrSession::getRecentred() == why; }));
    EXPECT_TRUE(framesUntil([&] { return ::says(*box.scene, why); }));
    EXPECT_TRUE(says(why));
    // It is calibrated again.
    box.scene->setCalibration(osg::Matrix::translate(0.01, 0.0, 0.0));
    EXPECT_TRUE(framesUntil([] { return XrSession::getRecentred().empty(); }));
}

TEST_F(Headset, AnAnchorStaysWhenTheSpaceIsMoved)
{
    {
        const FakeAccess fake;
        fake->extensions.emplace_back("XR_MSFT_spatial_anchor");
        fake->anchorsRefused = 2;
    }
    show(whiteFace());
    ASSERT_TRUE(drawn(10));
    FakeAccess()->spaceMoved = {0.1F, -0.05F, 0.2F};
    FakeAccess()->otherEvent = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
    ASSERT_TRUE(framesUntil([] { return FakeAccess()->otherEvent == XR_TYPE_UNKNOWN; }));
    ASSERT_TRUE(drawn(5));
    EXPECT_EQ(XrSession::getRecentred(), "");
    const FakeAccess fake;
    for (const FakePicture& picture : fake->pictures)
    {
        const BrightSpot expected = expectedOf(picture, picture.truePose);
        ASSERT_GT(expected.count, 200.0);
        EXPECT_LE((brightOf(picture).at() - expected.at()).norm(), 0.5);
        EXPECT_LE(picture.off_m, 1e-3);
    }
}

TEST_F(Headset, WhatIsAlwaysSaidStandsInTheWorld)
{
    BoxScene box;
    const osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    overlays->setShowAll(false);
    overlays->get<Hud>()->setKeyTime(0.0);
    FakeAccess()->width = 800;
    FakeAccess()->height = 960;
    box.scene->addChild(overlays);
    box.scene->setMuted(true);
    box.surface->setNodeMask(~1U); // it isn't drawn
    show(box.scene, 1U);
    std::array<BrightSpot, 2> seen;
    ASSERT_TRUE(framesUntil(
        [&]
        {
            const FakeAccess fake;
            if (fake->framesDrawn < 5) return false;
            for (std::size_t i = 0; i < 2; ++i)
                seen[i] = brightOf(fake->pictures[i]);
            return seen[0].count > 100.0 && seen[1].count > 100.0;
        }));
    const FakeAccess fake;
    std::array<Vector3d, 2> rays;
    for (std::size_t i = 0; i < 2; ++i)
    {
        const FakePicture& picture = fake->pictures[i];
        const auto tangent = [](double share, double from, double end)
        { return std::tan(from) + share * (std::tan(end) - std::tan(from)); };
        const Vector3d eye(
            tangent(
                seen[i].at().x() / picture.width, picture.fov.angleLeft, picture.fov.angleRight),
            tangent(seen[i].at().y() / picture.height, picture.fov.angleDown, picture.fov.angleUp),
            -1.0);
        const XrQuaternionf& q = picture.truePose.orientation;
        rays[i] = Eigen::Quaterniond(q.w, q.x, q.y, q.z) * eye;
        rays[i] /= -rays[i].z();
    }
    // Eyes 64 mm apart, and a sheet 0.8 m ahead; a pixel is about 2.4 mrad here.
    // The middle of a word that is 20 degrees wide is another one for canted eyes; at one place of
    // the viewports it would be 0.35.
    EXPECT_NEAR(rays[0].x() - rays[1].x(), 0.064 / 0.8, 0.01);
    EXPECT_NEAR(rays[0].y(), rays[1].y(), 0.0025);
}

TEST_F(Headset, WithoutARuntimeItSaysWhy)
{
    setenv("XR_RUNTIME_JSON", "/nowhere/runtime.json", 1);
    std::string error;
    EXPECT_FALSE(HeadsetView::open("openxr:", error));
    EXPECT_EQ(
        error,
        "openxr: the loader finds no OpenXR runtime (XR_ERROR_RUNTIME_UNAVAILABLE); no picture "
        "in a headset. Install one, such as Monado, or name its manifest in XR_RUNTIME_JSON");
    setenv("XR_RUNTIME_JSON", MIDAIR_FAKE_OPENXR, 1);
    FakeAccess()->extensions = {"XR_MND_headless"};
    error.clear();
    EXPECT_FALSE(HeadsetView::open("openxr:", error));
    EXPECT_EQ(
        error,
        "openxr: Fake XR 1.2.3 has no XR_KHR_opengl_enable; no picture in a headset. It takes "
        "a runtime with XR_KHR_opengl_enable, such as Monado");
    error.clear();
    EXPECT_FALSE(HeadsetView::open("openxr:?speed=2", error));
    EXPECT_EQ(error,
              "headset \"openxr:?speed=2\": unknown parameter \"speed\"; known are loader, matrix, "
              "space");
}

TEST_F(Headset, TheValidationLayerIsSilent)
{
    const std::filesystem::path layers = "/usr/share/openxr/1/api_layers/explicit.d";
    if (!std::filesystem::exists(layers))
        GTEST_SKIP() << "openxr-layer-corevalidation isn't installed";
    const std::string file = testing::TempDir() + "validation.txt";
    std::filesystem::remove(file);
    setenv("XR_ENABLE_API_LAYERS", "XR_APILAYER_LUNARG_core_validation", 1);
    setenv("XR_CORE_VALIDATION_EXPORT_TYPE", "text", 1);
    setenv("XR_CORE_VALIDATION_FILE_NAME", file.c_str(), 1);
    BoxScene box;
    box.scene->setHands("openxr:");
    // Of passthrough Debian's layer says that it is no layer: the registry of its time has it so.
    show(box.scene);
    const bool isDrawn = drawn(10);
    headset = nullptr;
    viewer.reset();
    for (const char* name :
         {"XR_ENABLE_API_LAYERS", "XR_CORE_VALIDATION_EXPORT_TYPE", "XR_CORE_VALIDATION_FILE_NAME"})
        unsetenv(name);
    EXPECT_TRUE(isDrawn);
    std::ifstream in(file);
    std::ostringstream said;
    said << in.rdbuf();
    EXPECT_EQ(said.str().find("VUID"), std::string::npos) << said.str().substr(0, 3000);
    EXPECT_EQ(said.str().find("rror"), std::string::npos) << said.str().substr(0, 3000);
}

} // namespace

} // namespace osgMidair
