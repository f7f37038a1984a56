#include "engine-bridge/pipeline/HologramPipeline.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/scene/MeshExtractor.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/propagation/PressureField.h"
#include "plugin/engine/SceneAccess.h"
#include "samples/demo/DemoScene.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/scene/ExtractedMesh.h"

#include <osgMidair/HapticSurface>

#include <osg/Material>

#include <algorithm>

#include <gtest/gtest.h>

using namespace midair;

namespace
{

constexpr int kWidth = 640;
constexpr int kHeight = 480;
const osg::Vec4 kMagenta(1.0F, 0.0F, 1.0F, 1.0F);

/// Nearest place on triangle \a a \a b \a c to \a p (C. Ericson, Real-Time Collision Detection,
/// 2005, section 5.1.5: by the regions of the corners, edges and the face).
Eigen::Vector3d nearestOnTriangle(const Eigen::Vector3d& p,
                                  const Eigen::Vector3d& a,
                                  const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c)
{
    const auto onSegment = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to)
    {
        const Eigen::Vector3d d = to - from;
        return Eigen::Vector3d(from +
                               std::clamp((p - from).dot(d) / d.squaredNorm(), 0.0, 1.0) * d);
    };
    const Eigen::Vector3d n = (b - a).cross(c - a);
    const bool inside = n.cross(b - a).dot(p - a) >= 0.0 && n.cross(c - b).dot(p - b) >= 0.0 &&
                        n.cross(a - c).dot(p - c) >= 0.0;
    if (inside) return p - n * (n.dot(p - a) / n.squaredNorm());
    Eigen::Vector3d best = onSegment(a, b);
    for (const Eigen::Vector3d& other : {onSegment(b, c), onSegment(c, a)})
        if ((other - p).norm() < (best - p).norm()) best = other;
    return best;
}

double distance(const Eigen::Vector3d& p, const haptics::TriangleMesh& mesh)
{
    double best = 1e9;
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
        best = std::min(best,
                        (nearestOnTriangle(p,
                                           mesh.vertices.col(mesh.triangles(0, t)),
                                           mesh.vertices.col(mesh.triangles(1, t)),
                                           mesh.vertices.col(mesh.triangles(2, t))) -
                         p)
                            .norm());
    return best;
}

/// The mesh of the scene's surface where it is now, in the world.
haptics::TriangleMesh meshInWorld(osg::Node& root)
{
    class Find : public osg::NodeVisitor
    {
    public:
        Find() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
        void apply(osg::Group& group) override
        {
            if (dynamic_cast<osgMidair::HapticSurface*>(&group))
            {
                world = osg::computeLocalToWorld(getNodePath());
                found = &group;
                return;
            }
            traverse(group);
        }
        osg::Node* found = nullptr;
        osg::Matrix world;
    } find;
    root.accept(find);
    haptics::TriangleMesh mesh = bridge::extractMesh(*find.found).mesh();
    for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i)
    {
        const osg::Vec3d v =
            osg::Vec3d(mesh.vertices(0, i), mesh.vertices(1, i), mesh.vertices(2, i)) * find.world;
        mesh.vertices.col(i) = Eigen::Vector3d(v.x(), v.y(), v.z());
    }
    return mesh;
}

/// The place of the largest |p| that the device plays, searched through the whole box that the
/// object moves in: samples a third of a wavelength apart, then ever finer round the best.
Eigen::Vector3d strongestSpot(const bridge::HologramResult& result,
                              const haptics::TransducerArray& array,
                              const haptics::Medium& medium)
{
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    Eigen::Vector3d half(0.095, 0.055, 0.095);
    double step = 0.006;
    for (int round = 0; round < 4; ++round)
    {
        const Eigen::Array3i n = (half.array() / step).floor().cast<int>();
        Eigen::Matrix3Xd places(3, (2 * n + 1).prod());
        Eigen::Index k = 0;
        for (int x = -n.x(); x <= n.x(); ++x)
            for (int y = -n.y(); y <= n.y(); ++y)
                for (int z = -n.z(); z <= n.z(); ++z)
                    places.col(k++) = best + step * Eigen::Vector3d(x, y, z);
        haptics::pressureAt(places, array, medium, result.played(), 2).cwiseAbs().maxCoeff(&k);
        best = places.col(k);
        half = Eigen::Vector3d::Constant(step);
        step /= 3.0;
    }
    return best;
}

/// Draws the object of \a scene, its first child, opaque, unlit and in \a color, without its edges.
void paintPlain(osgMidair::HapticScene& scene, const osg::Vec4& color)
{
    osg::Group& moved = *scene.getChild(0)->asGroup();
    moved.getChild(1)->setNodeMask(0); // behind the object its edges
    osg::ref_ptr<osg::Material> material = new osg::Material;
    for (const auto set :
         {&osg::Material::setAmbient, &osg::Material::setDiffuse, &osg::Material::setSpecular})
        (*material.*set)(osg::Material::FRONT_AND_BACK, {0.0F, 0.0F, 0.0F, 1.0F});
    material->setEmission(osg::Material::FRONT_AND_BACK, color);
    osg::StateSet* state = scene.getOrCreateStateSet();
    constexpr auto kForced =
        osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE | osg::StateAttribute::PROTECTED;
    state->setAttributeAndModes(material, kForced);
    state->setMode(GL_BLEND, osg::StateAttribute::OFF | osg::StateAttribute::OVERRIDE);
}

} // namespace

/// What is seen and what is felt are in the same place: in frames of a moving star, the strongest
/// spot of the field that the simulated device plays lies on the surface within half a wavelength,
/// and in the picture of the same frame on the pixels of the object.
class Coincidence : public ::testing::TestWithParam<int>
{
protected:
    /// World -> array: the array where the world is, or turned and shifted.
    static osg::Matrix calibration()
    {
        return GetParam() == 0 ? osg::Matrix::identity()
                               : osg::Matrix::rotate(0.5, osg::Y_AXIS) *
                                     osg::Matrix::translate(0.012, -0.006, 0.009);
    }
};

TEST_P(Coincidence, StrongestSpotLiesOnTheVisibleSurface)
{
    samples::DemoOptions options;
    options.object = {{"sampling", "vertices"}};
    samples::DemoScene scene(options);
    scene.haptics().setCalibration(calibration());
    const osg::Matrix toWorld = osg::Matrix::inverse(calibration());
    osgViewer::Viewer viewer;
    std::string problem;
    const bool draw =
        samples::setUpOffscreen(viewer, kWidth, kHeight, samples::DemoScene::kFovy_deg, &problem);
    osg::Vec3d eye;
    osg::Vec3d centre;
    osg::Vec3d up;
    samples::DemoScene::lookAt(eye, centre, up);
    viewer.getCamera()->setViewMatrixAsLookAt(eye, centre, up);
    viewer.getCamera()->setClearColor({0.0F, 0.0F, 0.0F, 1.0F});
    const osg::ref_ptr<samples::FrameGrabber> grabber = new samples::FrameGrabber;
    viewer.getCamera()->setFinalDrawCallback(grabber);
    viewer.setSceneData(scene.root());
    // The object alone, in one colour that nothing else has.
    scene.overlays().setNodeMask(0);
    paintPlain(scene.haptics(), kMagenta);

    for (const double time_s : {0.0, 0.9, 2.3, 4.1})
    {
        SCOPED_TRACE(time_s);
        std::uint64_t frame = 0;
        // Frames before it move too: the field has to be of this one.
        for (const double earlier : {0.10, 0.05, 0.0})
        {
            scene.moveTo(time_s - earlier);
            viewer.advance(time_s - earlier);
            viewer.eventTraversal();
            viewer.updateTraversal();
            if (draw && earlier == 0.0) grabber->request();
            if (draw) viewer.renderingTraversals();
            frame = viewer.getFrameStamp()->getFrameNumber();
        }
        std::shared_ptr<const bridge::HologramResult> result;
        ASSERT_TRUE(eventually(
            [&]
            {
                result = osgMidair::SceneAccess::latestResult(scene.haptics());
                return result && result->frame >= frame;
            },
            120.0));
        ASSERT_EQ(result->frame, frame);
        const auto array = osgMidair::SceneAccess::engine(scene.haptics()).array();
        const haptics::Medium medium = osgMidair::SceneAccess::engine(scene.haptics()).medium();
        const double half = 0.5 * medium.wavelength(array->frequency_Hz);
        const Eigen::Vector3d played = strongestSpot(*result, *array, medium);
        const osg::Vec3d place = osg::Vec3d(played.x(), played.y(), played.z()) * toWorld;
        const Eigen::Vector3d spot(place.x(), place.y(), place.z());
        EXPECT_LT(distance(spot, meshInWorld(*scene.root())), half);

        if (!draw) continue;
        const osg::ref_ptr<osg::Image> picture = grabber->image();
        ASSERT_TRUE(picture.valid());
        const osg::Matrix toWindow = viewer.getCamera()->getViewMatrix() *
                                     viewer.getCamera()->getProjectionMatrix() *
                                     viewer.getCamera()->getViewport()->computeWindowMatrix();
        const osg::Vec3d seen = place * toWindow;
        // What half a wavelength is in pixels there, across the line of sight.
        osg::Vec3d side = (centre - eye) ^ up;
        side.normalize();
        const double reach = ((place + side * half) * toWindow - seen).length();
        double nearest = 1e9;
        int pixels = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
            {
                const osg::Vec4 color = picture->getColor(x, y);
                if (color.r() < 0.2F || color.g() > 0.5F * color.r()) continue;
                ++pixels;
                nearest = std::min(nearest, std::hypot(x + 0.5 - seen.x(), y + 0.5 - seen.y()));
            }
        EXPECT_GT(pixels, 500);
        EXPECT_LT(nearest, reach);
    }
    if (!draw) GTEST_SKIP() << "measured in the field only: " << problem;
}

INSTANTIATE_TEST_SUITE_P(Calibrations, Coincidence, ::testing::Values(0, 1));
