#include "engine-bridge/scene/Convert.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/engine-bridge/display/LightTracer.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/DisplayView>
#include <osgMidair/HandSource>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/CullFace>
#include <osg/FrontFace>
#include <osg/Geometry>
#include <osg/LightSource>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgGA/OrbitManipulator>
#include <osgText/Text>
#include <osgViewer/Renderer>
#include <osgViewer/Viewer>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace osgMidair
{

namespace
{

using Eigen::Vector2d;
using Eigen::Vector3d;
using midair::bridge::Display;
using midair::bridge::StereoMode;

constexpr double kHalf_m = 0.015; ///< half of a face's edge

std::string listOf(const Vector3d& v)
{
    return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

/// A display as its file has it.
std::string textOf(const Display& display)
{
    std::string optics;
    for (const midair::bridge::Optic& optic : display.optics)
        optics +=
            fmt::format(R"({}{{"kind": "{}", "point_m": {}, "normal": {}}})",
                        optics.empty() ? "" : ", ",
                        optic.kind == midair::bridge::Optic::Kind::PLATE ? "plate" : "half-mirror",
                        listOf(optic.point),
                        listOf(optic.normal));
    return fmt::format(
        R"({{"screen": {{"lowerLeft_m": {}, "lowerRight_m": {}, "upperLeft_m": {}, "pixels": [{}, {}]}},
            "optics": [{}], "eye": "{}", "ipd_m": {}, "stereo": "{}"}})",
        listOf(display.lowerLeft),
        listOf(display.lowerRight),
        listOf(display.upperLeft),
        display.width,
        display.height,
        optics,
        display.eye,
        display.ipd_m,
        midair::bridge::stereoNames()[static_cast<std::size_t>(display.stereo)]);
}

/// A face around \a at, seen from where \a normal points to, with the corners in turn.
std::array<Vector3d, 4> cornersOf(const Vector3d& at, const Vector3d& normal)
{
    const Vector3d up = Vector3d::UnitZ();
    const Vector3d right = up.cross(normal).normalized();
    return {at - kHalf_m * right - kHalf_m * up,
            at + kHalf_m * right - kHalf_m * up,
            at + kHalf_m * right + kHalf_m * up,
            at - kHalf_m * right + kHalf_m * up};
}

osg::ref_ptr<osg::Geometry> face(const Vector3d& at, const Vector3d& normal)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const Vector3d& corner : cornersOf(at, normal))
        vertices->push_back(osg::Vec3(midair::bridge::toOsg(corner)));
    const osg::Vec3 way(midair::bridge::toOsg(normal));
    const osg::Vec4 white(1.0F, 1.0F, 1.0F, 1.0F);
    geometry->setVertexArray(vertices);
    geometry->setNormalArray(new osg::Vec3Array(1, &way), osg::Array::BIND_OVERALL);
    geometry->setColorArray(new osg::Vec4Array(1, &white), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_FAN, 0, 4));
    geometry->getOrCreateStateSet()->setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK));
    return geometry;
}

/// A viewer without a window that shows \a root on \a display.
struct Seen
{
    Seen(const Display& display,
         osg::Node* root,
         const Eigen::Isometry3d& head,
         const std::string& how = {})
    {
        std::string error;
        viewer.setLightingMode(osg::View::NO_LIGHT);
        isThere =
            midair::samples::setUpOffscreen(viewer, display.width, display.height, 30.0, &error);
        EXPECT_TRUE(isThere) << error;
        viewer.setSceneData(root);
        viewer.getCamera()->setClearColor(osg::Vec4(0, 0, 0, 1));
        view = DisplayView::open(how + textOf(display), error);
        EXPECT_TRUE(view) << error;
        if (!view) return;
        view->setHead(midair::bridge::toOsg(head.matrix()));
        EXPECT_TRUE(view->attach(viewer, error)) << error;
    }

    osg::ref_ptr<osg::Image> picture()
    {
        viewer.frame();
        viewer.frame();
        osg::GraphicsContext* context = viewer.getCamera()->getGraphicsContext();
        context->makeCurrent();
        const osg::ref_ptr<osg::Image> image = new osg::Image;
        image->readPixels(0,
                          0,
                          context->getTraits()->width,
                          context->getTraits()->height,
                          GL_RGB,
                          GL_UNSIGNED_BYTE);
        context->releaseContext();
        return image;
    }

    osgViewer::Viewer viewer;
    osg::ref_ptr<DisplayView> view;
    bool isThere = false;
};

/// Where an eye's picture is in the window's pixels: column = x + column * width ...
struct Part
{
    double x = 0.0;
    double y = 0.0;
    double across = 1.0; ///< the window's pixels for one of the screen
    double up = 1.0;
    int channel = 0; ///< of the colours
    int rows = 0;    ///< 1: rows alone that the other eye hasn't; 2: columns; 3: both
};

struct Spot
{
    double count = 0.0;
    Vector2d middle = Vector2d::Zero();

    void add(double x, double y)
    {
        count += 1.0;
        middle += Vector2d(x, y);
    }
    void finish() { middle /= std::max(1.0, count); }
};

bool isWithin(const std::vector<Vector2d>& polygon, const Vector2d& at)
{
    if (std::all_of(polygon.begin(),
                    polygon.end(),
                    [&at](const Vector2d& corner) { return (corner - at).norm() > 100.0; }))
        return false;
    double turn = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        const Vector2d a = polygon[i] - at;
        const Vector2d b = polygon[(i + 1) % polygon.size()] - at;
        turn += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
    return std::abs(turn) > 3.0;
}

/// Compares what \a image has of a face at \a at, in the part of an eye, with where light says it
/// is: pixels one by one, their middle, and how far the sight of the middle passes by the face's.
void expectSeen(const osg::Image& image,
                const Display& display,
                const Part& part,
                const Vector3d& eye,
                const Vector3d& at,
                const std::string& what)
{
    const LightTracer tracer(display);
    std::vector<Vector2d> corners;
    for (const Vector3d& corner : cornersOf(at, -Vector3d::UnitY()))
    {
        const auto pixel = tracer.pixel(eye, corner);
        ASSERT_TRUE(pixel) << what;
        corners.emplace_back(part.x + part.across * pixel->x(), part.y + part.up * pixel->y());
    }
    Spot drawn;
    Spot expected;
    int wrong = 0;
    const int endX = static_cast<int>(part.x + part.across * display.width);
    const int endY = static_cast<int>(part.y + part.up * display.height);
    // Of two eyes in turn, those pixels that are of this one.
    const auto isMine = [&](int x, int y)
    {
        const int turn = part.rows == 1 ? y : part.rows == 2 ? x : x + y;
        return part.rows == 0 || turn % 2 == part.channel % 2;
    };
    for (int y = static_cast<int>(part.y); y < endY; ++y)
        for (int x = static_cast<int>(part.x); x < endX; ++x)
        {
            if (!isMine(x, y)) continue;
            const bool isDrawn = image.data(x, y)[part.rows == 0 ? part.channel : 0] > 127;
            const bool isExpected = isWithin(corners, {x + 0.5, y + 0.5});
            if (isDrawn) drawn.add(x + 0.5, y + 0.5);
            if (isExpected) expected.add(x + 0.5, y + 0.5);
            if (isDrawn != isExpected) ++wrong;
        }
    drawn.finish();
    expected.finish();
    ASSERT_GT(expected.count, 50.0) << what;
    EXPECT_LE(wrong, 2) << what << ": pixels";
    EXPECT_LE((drawn.middle - expected.middle).norm(), 0.5) << what;
    const Vector2d seen((drawn.middle.x() - part.x) / part.across,
                        (drawn.middle.y() - part.y) / part.up);
    EXPECT_LE(tracer.missOf(eye, at, seen), 0.7e-3) << what;
}

/// The parts of the left and the right eye.
std::array<Part, 2> partsOf(const Display& display)
{
    Part left;
    Part right;
    switch (display.stereo)
    {
    case StereoMode::SIDE_BY_SIDE:
        left.across = right.across = 0.5;
        right.x = 0.5 * display.width;
        break;
    case StereoMode::TOP_BOTTOM:
        left.up = right.up = 0.5;
        left.y = 0.5 * display.height;
        break;
    case StereoMode::ANAGLYPH:
        right.channel = 1;
        break;
    case StereoMode::HORIZONTAL_INTERLACE:
    case StereoMode::VERTICAL_INTERLACE:
    case StereoMode::CHECKERBOARD:
        left.rows = right.rows = 1 + static_cast<int>(display.stereo) -
                                 static_cast<int>(StereoMode::HORIZONTAL_INTERLACE);
        // OSG counts rows from the upper edge.
        right.channel = display.stereo == StereoMode::HORIZONTAL_INTERLACE ? 0 : 1;
        left.channel = 1 - right.channel;
        break;
    default:
        break;
    }
    return {left, right};
}

osg::ref_ptr<osg::Group> oneFace(const Vector3d& at, const Vector3d& normal)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(face(at, normal));
    root->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    return root;
}

const Vector3d kPlaces[] = {{0.03, -0.04, 0.17}, {-0.05, 0.03, 0.12}};

} // namespace

TEST(DisplayView, ShowsWhereLightThroughTheOpticsComesFrom)
{
    for (const auto& [name, display] : displays::all())
        for (const double tilt_deg : {0.0, 20.0})
            for (const Vector3d& at : kPlaces)
            {
                const Eigen::Isometry3d head = displays::head(tilt_deg);
                const osg::ref_ptr<osg::Group> root = oneFace(at, -Vector3d::UnitY());
                Seen seen(display, root, head);
                ASSERT_TRUE(seen.isThere && seen.view);
                expectSeen(*seen.picture(), display, {}, head.translation(), at, name);
            }
}

TEST(DisplayView, ShowsBothEyesInAllStereoModes)
{
    using M = StereoMode;
    for (auto [name, display] : displays::all())
        for (const M mode : {M::ANAGLYPH,
                             M::SIDE_BY_SIDE,
                             M::TOP_BOTTOM,
                             M::LEFT_EYE,
                             M::RIGHT_EYE,
                             M::HORIZONTAL_INTERLACE,
                             M::VERTICAL_INTERLACE,
                             M::CHECKERBOARD})
        {
            display.stereo = mode;
            const Eigen::Isometry3d head = displays::head(20.0);
            const Vector3d at = kPlaces[0];
            const osg::ref_ptr<osg::Group> root = oneFace(at, -Vector3d::UnitY());
            Seen seen(display, root, head);
            ASSERT_TRUE(seen.isThere && seen.view);
            const osg::ref_ptr<osg::Image> image = seen.picture();
            const std::array<Part, 2> parts = partsOf(display);
            const std::string what = fmt::format(
                "{}, {}", name, midair::bridge::stereoNames()[static_cast<std::size_t>(mode)]);
            for (const int side : {-1, 1})
            {
                if ((mode == M::LEFT_EYE && side > 0) || (mode == M::RIGHT_EYE && side < 0))
                    continue;
                const Vector3d eye = head * Vector3d(0.5 * side * display.ipd_m, 0.0, 0.0);
                expectSeen(*image, display, parts[side < 0 ? 0 : 1], eye, at, what);
            }
        }
}

// No window here has quad buffers; the eyes' matrices are those that OSG draws them with.
TEST(DisplayView, HasBothEyesForQuadBuffers)
{
    for (auto [name, display] : displays::all())
    {
        display.stereo = StereoMode::QUAD_BUFFER;
        const Eigen::Isometry3d head = displays::head(20.0);
        const osg::ref_ptr<osg::Group> root = oneFace(kPlaces[0], -Vector3d::UnitY());
        Seen seen(display, root, head);
        ASSERT_TRUE(seen.isThere && seen.view);
        ASSERT_EQ(seen.view->getMessages().size(), 1U);
        EXPECT_EQ(seen.view->getMessages()[0].rfind("the window has no quad buffers", 0), 0U);
        const auto* renderer =
            dynamic_cast<osgViewer::Renderer*>(seen.viewer.getCamera()->getRenderer());
        ASSERT_TRUE(renderer);
        for (const unsigned int i : {0U, 1U})
            for (const int side : {-1, 1})
            {
                const osgUtil::SceneView& drawn = *renderer->getSceneView(i);
                const osg::Matrixd before;
                const osg::Matrixd both = side < 0 ? drawn.computeLeftEyeView(before) *
                                                         drawn.computeLeftEyeProjection(before)
                                                   : drawn.computeRightEyeView(before) *
                                                         drawn.computeRightEyeProjection(before);
                const osg::Vec3d at = midair::bridge::toOsg(kPlaces[1]) * both;
                const auto truth = LightTracer(display).pixel(
                    head * Vector3d(0.5 * side * display.ipd_m, 0.0, 0.0), kPlaces[1]);
                ASSERT_TRUE(truth);
                EXPECT_NEAR(0.5 * (at.x() + 1.0) * display.width, truth->x(), 1e-6) << name;
                EXPECT_NEAR(0.5 * (at.y() + 1.0) * display.height, truth->y(), 1e-6) << name;
            }
    }
}

// Middles of pixels don't see faces that are inside out.
TEST(DisplayView, ShowsTheFrontsOfFaces)
{
    for (const auto& [name, display] : displays::all())
        for (const bool saysItself : {false, true})
            for (const bool isFront : {true, false})
            {
                const Vector3d at = kPlaces[0];
                const osg::ref_ptr<osg::Group> root =
                    oneFace(at, Vector3d(0.0, isFront ? -1.0 : 1.0, 0.0));
                if (saysItself)
                    root->getChild(0)->getOrCreateStateSet()->setAttribute(
                        new osg::FrontFace(osg::FrontFace::COUNTER_CLOCKWISE));
                Seen seen(display, root, displays::head(0.0));
                ASSERT_TRUE(seen.isThere && seen.view);
                const osg::ref_ptr<osg::Image> image = seen.picture();
                int bright = 0;
                for (int y = 0; y < image->t(); ++y)
                    for (int x = 0; x < image->s(); ++x)
                        if (image->data(x, y)[0] > 127) ++bright;
                if (isFront)
                    EXPECT_GT(bright, 100) << name;
                else
                    EXPECT_EQ(bright, 0) << name;
            }
}

// A lamp at the right of the world shines on faces that are turned to the right, in every picture.
TEST(DisplayView, IsLitFromWhereTheLampIs)
{
    for (const auto& [name, display] : displays::all())
        for (const double side : {1.0, -1.0})
        {
            const osg::ref_ptr<osg::Group> root = new osg::Group;
            const osg::ref_ptr<osg::LightSource> lamp = new osg::LightSource;
            lamp->getLight()->setPosition(osg::Vec4(1.0F, 0.0F, 0.0F, 0.0F));
            lamp->getLight()->setDiffuse(osg::Vec4(1.0F, 1.0F, 1.0F, 1.0F));
            lamp->getLight()->setAmbient(osg::Vec4(0.0F, 0.0F, 0.0F, 1.0F));
            root->addChild(lamp);
            root->addChild(face({0.0, 0.0, 0.15}, Vector3d(0.6 * side, -0.8, 0.0)));
            root->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::ON);
            root->getOrCreateStateSet()->setMode(GL_LIGHT0, osg::StateAttribute::ON);
            Seen seen(display, root, displays::head(0.0));
            ASSERT_TRUE(seen.isThere && seen.view);
            const osg::ref_ptr<osg::Image> image = seen.picture();
            const auto pixel = LightTracer(display).pixel({0.02, -0.8, 0.28}, {0.0, 0.0, 0.15});
            ASSERT_TRUE(pixel);
            const int shade =
                image->data(static_cast<int>(pixel->x()), static_cast<int>(pixel->y()))[0];
            // Lambert: 0.6 of the lamp, and OSG's tenth that is around anyway.
            EXPECT_NEAR(shade, 255 * ((side > 0.0 ? 0.6 : 0.0) + 0.1), 2) << name;
        }
}

// What the window shows of the scene came by the screen and the optics, not by the window's camera.
TEST(DisplayView, RehearsesWhatIsSeenWhereItIsFelt)
{
    for (const auto& [name, display] : displays::all())
    {
        const Vector3d at = kPlaces[0];
        const osg::ref_ptr<osg::Group> root = oneFace(at, -Vector3d::UnitY());
        Seen seen(display, root, displays::head(0.0), "sim:");
        ASSERT_TRUE(seen.isThere && seen.view);
        const osg::ref_ptr<osg::Image> image = seen.picture();
        const osg::Camera& camera = *seen.viewer.getCamera();
        EXPECT_NE(seen.viewer.getSceneData(), root.get());
        const osg::Vec3d there =
            midair::bridge::toOsg(at) * camera.getViewMatrix() * camera.getProjectionMatrix();
        const Vector2d expected(0.5 * (there.x() + 1.0) * display.width,
                                0.5 * (there.y() + 1.0) * display.height);
        Spot drawn;
        constexpr int kAround = 40;
        for (int y = -kAround; y <= kAround; ++y)
            for (int x = -kAround; x <= kAround; ++x)
            {
                const int column = static_cast<int>(expected.x()) + x;
                const int row = static_cast<int>(expected.y()) + y;
                if (image->data(column, row)[0] > 110) drawn.add(column + 0.5, row + 0.5);
            }
        drawn.finish();
        EXPECT_GT(drawn.count, 50.0) << name;
        EXPECT_LE((drawn.middle - expected).norm(), 1.0) << name;
    }
}

// A picture that is added to the room's light would shine over the finger before the object; where
// the screen itself is seen the finger covers it anyway.
TEST(DisplayView, DrawsNothingBehindAFinger)
{
    for (const auto& [name, display] : displays::all())
        for (const char* how : {"", "sim:"})
            for (const double before_m : {0.03, -0.03})
            {
                const Vector3d at = kPlaces[0];
                const Eigen::Isometry3d head = displays::head(0.0);
                const osg::ref_ptr<osg::Group> root = oneFace(at, -Vector3d::UnitY());
                const osg::ref_ptr<HapticScene> scene = new HapticScene;
                scene->setArray("board");
                const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
                const Vector3d finger = at + before_m * (head.translation() - at).normalized();
                hands->setHands({openHand(1,
                                          osg::Vec3d(finger.x(), finger.y(), finger.z() + 0.012),
                                          osg::Quat(osg::PI, osg::Vec3d(1, 0, 0)))});
                scene->setHandSource(hands);
                const osg::ref_ptr<HapticSurface> aside = new HapticSurface;
                aside->addChild(new osg::ShapeDrawable(new osg::Box({0.3F, 0.0F, 0.1F}, 0.02F)));
                scene->addChild(aside);
                root->addChild(scene);
                Seen seen(display, root, head, how);
                ASSERT_TRUE(seen.isThere && seen.view);
                seen.picture();
                const osg::ref_ptr<osg::Image> image = seen.picture();
                // In a rehearsal the texture of the screen is looked at below, by the eye's camera.
                const osg::Camera& camera = *seen.viewer.getCamera();
                const osg::Vec3d there = midair::bridge::toOsg(at) * camera.getViewMatrix() *
                                         camera.getProjectionMatrix();
                const int x = static_cast<int>(0.5 * (there.x() + 1.0) * display.width);
                const int y = static_cast<int>(0.5 * (there.y() + 1.0) * display.height);
                const bool isHidden = before_m > 0.0 && !display.optics.empty();
                const std::string what = fmt::format("{}{}, {} m", how, name, before_m);
                if (*how == 0)
                {
                    EXPECT_EQ(image->data(x, y)[2], isHidden ? 0 : 255) << what;
                }
                // Half of a finger's width aside there is the face in any case.
                const osg::Vec3d next = (midair::bridge::toOsg(at) + osg::Vec3d(0.0125, 0, 0)) *
                                        camera.getViewMatrix() * camera.getProjectionMatrix();
                const int beside = static_cast<int>(0.5 * (next.x() + 1.0) * display.width);
                if (*how == 0)
                {
                    EXPECT_EQ(image->data(beside, y)[2], 255) << what;
                }
                if (*how != 0 && isHidden && std::string(name) == "half mirror")
                {
                    EXPECT_LT(image->data(x, y)[2], 200) << what;
                }
            }
}

// Another thread may still draw the frame before with it.
TEST(DisplayView, ChangesTheCamerasStateOnce)
{
    const osg::ref_ptr<osg::Group> root = oneFace(kPlaces[0], -Vector3d::UnitY());
    Seen seen(displays::halfMirror(), root, displays::head(0.0));
    ASSERT_TRUE(seen.isThere && seen.view);
    const osg::ref_ptr<const osg::StateAttribute> before =
        seen.viewer.getCamera()->getStateSet()->getAttribute(osg::StateAttribute::FRONTFACE);
    ASSERT_TRUE(before);
    seen.view->update(1e6);
    EXPECT_EQ(seen.viewer.getCamera()->getStateSet()->getAttribute(osg::StateAttribute::FRONTFACE),
              before);
}

// MUTED has to be seen there, too.
TEST(DisplayView, DrawsTextOverThePicture)
{
    const osg::ref_ptr<osg::Group> root = oneFace(kPlaces[0], -Vector3d::UnitY());
    const osg::ref_ptr<osg::Camera> over = new osg::Camera;
    over->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    over->setRenderOrder(osg::Camera::POST_RENDER);
    over->setClearMask(0);
    over->setProjectionMatrix(osg::Matrix::ortho2D(0.0, 100.0, 0.0, 100.0));
    over->setViewMatrix(osg::Matrix::identity());
    over->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    over->getOrCreateStateSet()->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
    const osg::ref_ptr<osgText::Text> text = new osgText::Text;
    text->setText("MUTED");
    text->setCharacterSize(20.0F);
    text->setPosition({5.0F, 5.0F, 0.0F});
    text->setColor({0.0F, 0.0F, 1.0F, 1.0F});
    over->addChild(text);
    root->addChild(over);
    for (const Display& display : {displays::window(), displays::halfMirror()})
    {
        Seen seen(display, root, displays::head(0.0));
        ASSERT_TRUE(seen.isThere && seen.view);
        seen.picture(); // glyphs are made in the first frame
        const osg::ref_ptr<osg::Image> image = seen.picture();
        int blue = 0;
        for (int y = 0; y < image->t() / 3; ++y)
            for (int x = 0; x < image->s(); ++x)
            {
                const osg::Vec4 color = image->getColor(x, y);
                if (color.b() > 0.8F && color.r() < 0.3F && color.g() < 0.3F) ++blue;
            }
        EXPECT_GT(blue, 100);
    }
}

TEST(DisplayView, TakesManipulatorsAway)
{
    const osg::ref_ptr<osg::Group> root = oneFace(kPlaces[0], -Vector3d::UnitY());
    Seen seen(displays::window(), root, displays::head(0.0));
    ASSERT_TRUE(seen.isThere && seen.view);
    EXPECT_TRUE(seen.view->getMessages().empty());
    seen.viewer.setCameraManipulator(new osgGA::OrbitManipulator);
    const osg::ref_ptr<osg::Image> image = seen.picture();
    EXPECT_FALSE(seen.viewer.getCameraManipulator());
    ASSERT_EQ(seen.view->getMessages().size(), 1U);
    EXPECT_NE(seen.view->getMessages()[0].find("manipulator"), std::string::npos);
    expectSeen(*image, displays::window(), {}, {0.02, -0.8, 0.28}, kPlaces[0], "afterwards");
}

TEST(DisplayView, KeepsTheLastPlaceOfALostHead)
{
    const osg::ref_ptr<osg::Group> root = oneFace(kPlaces[0], -Vector3d::UnitY());
    Seen seen(displays::halfMirror(), root, displays::head(0.0));
    ASSERT_TRUE(seen.isThere && seen.view);
    seen.view->update(1e6);
    const osg::Matrixd before = seen.viewer.getCamera()->getViewMatrix();
    seen.view->setHead(midair::bridge::toOsg(displays::head(0.0, {0.1, -0.7, 0.3}).matrix()),
                       false);
    seen.view->update(1e6 + 0.19);
    EXPECT_TRUE(seen.view->getMessages().empty());
    seen.view->update(1e6 + 0.21);
    ASSERT_EQ(seen.view->getMessages().size(), 1U);
    EXPECT_NE(seen.view->getMessages()[0].find("head is lost"), std::string::npos);
    EXPECT_EQ(seen.viewer.getCamera()->getViewMatrix(), before);
    seen.view->setHead(midair::bridge::toOsg(displays::head(0.0, {0.1, -0.7, 0.3}).matrix()));
    seen.view->update(1e6 + 0.3);
    EXPECT_TRUE(seen.view->getMessages().empty());
    EXPECT_NEAR(seen.view->getEye().x(), 0.1, 1e-9);
}

/// A scene with one box, on a display whose eye is \a eye.
struct ShownScene
{
    explicit ShownScene(const std::string& eye, double outline_m = 0.2)
    {
        std::string error;
        display = DisplayView::open(
            fmt::format(
                R"({{"screen": {{"lowerLeft_m": [-0.2, 0.2, 0], "lowerRight_m": [0.2, 0.2, 0],
                        "upperLeft_m": [-0.2, 0.2, 0.3], "pixels": [64, 64]}}, "eye": "{}",
                        "optics": [{{"kind": "plate", "point_m": [0, 0, 0], "normal": [0, 1, 0],
                        "outline_m": [[-{}, 0, 0], [{}, 0, 0], [{}, 0, 0.3], [-{}, 0, 0.3]]}}]}})",
                eye,
                outline_m,
                outline_m,
                outline_m,
                outline_m),
            error);
        EXPECT_TRUE(display) << error;
        EXPECT_TRUE(display && display->attach(viewer.viewer, error)) << error;
    }
    /// The active messages of that code.
    std::vector<std::string> told(const std::string& code) const
    {
        std::vector<std::string> all;
        for (const HapticMessage& message : box.scene->getActiveMessages())
            if (message.code == code) all.push_back(message.text);
        return all;
    }

    BoxScene box;
    HeadlessViewer viewer{box.scene};
    osg::ref_ptr<DisplayView> display;
};

TEST(DisplayView, TellsTheSceneThatTheHeadIsLost)
{
    ShownScene shown("fixed 0 -0.8 0.15");
    ASSERT_TRUE(shown.display);
    EXPECT_TRUE(shown.told("display.head").empty());
    const osg::Matrixd head =
        osg::Matrixd::rotate(osg::PI_2, 1.0, 0.0, 0.0) * osg::Matrixd::translate(0.0, -0.7, 0.15);
    shown.display->setHead(head);
    shown.viewer.frames(2);
    EXPECT_TRUE(shown.told("display.head").empty());
    shown.display->setHead(head, false);
    shown.display->update(1e9);
    ASSERT_EQ(shown.told("display.head").size(), 1U);
    EXPECT_NE(shown.told("display.head")[0].find("head is lost"), std::string::npos);
    shown.display->setHead(head);
    shown.display->update(1e9 + 0.1);
    EXPECT_TRUE(shown.told("display.head").empty());
}

TEST(DisplayView, GivesTheSceneItsHeadThatMoves)
{
    ShownScene shown("fixed 0 -0.8 0.15");
    ASSERT_TRUE(shown.display);
    shown.viewer.frames(2);
    EXPECT_FALSE(shown.box.scene->getHeadSource()) << "one that rests keeps no scene awake";
    shown.display->setHead(osg::Matrixd::rotate(osg::PI_2, 1.0, 0.0, 0.0) *
                           osg::Matrixd::translate(0.1, -0.7, 0.15));
    shown.viewer.frames(3);
    Head head;
    ASSERT_TRUE(shown.box.scene->getHead(head));
    EXPECT_LT((head.position - osg::Vec3d(0.1, -0.7, 0.15)).length(), 1e-9);
}

TEST(DisplayView, LooksFromTheHeadOfTheScene)
{
    ShownScene shown("scene");
    ASSERT_TRUE(shown.display);
    shown.box.scene->setHeads("fixed 0.05 -0.75 0.2");
    shown.viewer.frames(3);
    EXPECT_LT((shown.display->getEye() - osg::Vec3d(0.05, -0.75, 0.2)).length(), 1e-9);
    EXPECT_FALSE(shown.box.scene->getHeadSource());
}

TEST(DisplayView, TellsHowMuchOfWhatIsFeltIsSeen)
{
    ShownScene wide("fixed 0 -0.8 0.15");
    wide.viewer.framesFor(1.2);
    EXPECT_TRUE(wide.told("display.view").empty()) << wide.told("display.view").front();
    ShownScene narrow("fixed 0 -0.8 0.15", 0.01);
    EXPECT_TRUE(narrow.viewer.framesUntil([&] { return !narrow.told("display.view").empty(); }));
    const std::vector<std::string> told = narrow.told("display.view");
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find(" % of the box"), std::string::npos) << told[0];
}

TEST(DisplayView, RefusesWhatIsNoDisplay)
{
    std::string error;
    EXPECT_FALSE(DisplayView::open("nowhere.display.json", error));
    EXPECT_EQ(error.rfind("display file \"nowhere.display.json\" ", 0), 0U) << error;
    Display display = displays::window();
    std::swap(display.lowerRight, display.upperLeft);
    EXPECT_FALSE(DisplayView::open(textOf(display), error));
    EXPECT_EQ(error,
              "description: the eye is 1.05 m behind the picture, most often because lowerRight_m "
              "and upperLeft_m are swapped");
    display = displays::window();
    display.eye = "fix 0 0 0";
    EXPECT_FALSE(DisplayView::open(textOf(display), error));
    EXPECT_NE(error.find("head source \"fix 0 0 0\" is not known"), std::string::npos) << error;
    osgViewer::Viewer several;
    several.addSlave(new osg::Camera);
    display.eye = "fixed 0 -0.8 0.3";
    const osg::ref_ptr<DisplayView> view = DisplayView::open(textOf(display), error);
    ASSERT_TRUE(view) << error;
    EXPECT_FALSE(view->attach(several, error));
    EXPECT_EQ(error,
              "the viewer has 1 slave cameras; a display is one window on one screen (osgviewer: "
              "--screen 0)");
    osgViewer::Viewer one;
    EXPECT_TRUE(view->attach(one, error)) << error;
    EXPECT_FALSE(view->attach(one, error));
    EXPECT_EQ(error, "the viewer has a display already");
}

TEST(DisplayView, TellsTheShareOfABoxThatIsSeen)
{
    std::string error;
    const osg::ref_ptr<DisplayView> view = DisplayView::open(textOf(displays::window()), error);
    ASSERT_TRUE(view) << error;
    EXPECT_NEAR(view->getVisibleShare({-0.05, -0.05, 0.1, 0.05, 0.05, 0.2}), 1.0, 1e-12);
    EXPECT_NEAR(view->getVisibleShare({-0.05, -0.05, -0.5, 0.05, 0.05, -0.4}), 0.0, 1e-12);
}

} // namespace osgMidair
