#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/FieldSlice.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldSliceOverlay>

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace haptics = midair::haptics;
namespace bridge = midair::bridge;
namespace samples = midair::samples;

namespace
{

constexpr int kSize = 256;
constexpr float kRange_Pa = 6000.0F;

std::shared_ptr<bridge::HologramResult>
focusedOn(const Eigen::Vector3d& focus, const haptics::TransducerArray& array, std::uint64_t frame)
{
    auto result = std::make_shared<bridge::HologramResult>();
    const Eigen::VectorXcd g =
        haptics::referencePropagationMatrix(focus, array, haptics::Medium()).row(0).adjoint();
    result->frame = frame;
    result->sequence.fields = {(g.array() / g.array().abs()).cast<std::complex<float>>()};
    result->points.positions = focus;
    result->points.normals = Eigen::Vector3d::UnitZ();
    result->points.targets = Eigen::VectorXd::Ones(1);
    return result;
}

/// A viewer that looks at an overlay alone, off screen.
class Look
{
public:
    Look() : overlay(new FieldSliceOverlay), _grabber(new samples::FrameGrabber)
    {
        array = std::make_shared<haptics::TransducerArray>(haptics::TransducerArray::singleBoard());
        array->gain = Eigen::VectorXd::LinSpaced(array->size(), 0.5, 1.0);
        array->phaseOffset_rad = Eigen::VectorXd::LinSpaced(array->size(), -1.0, 1.0);
        OverlayPart::of(*overlay).setArray(array, haptics::Medium());
        overlay->setPlane(osg::Vec3d(0.0, 0.0, 0.12), osg::Vec3d(0.0, 0.4, 1.0));
        overlay->setRadius(0.03);
        _viewer.setLightingMode(osg::View::NO_LIGHT);
        able = samples::setUpOffscreen(_viewer, kSize, kSize, 30.0, &problem);
        if (!able) return;
        _viewer.getCamera()->setClearColor({0.0F, 0.0F, 0.0F, 1.0F});
        _viewer.getCamera()->setViewMatrixAsLookAt(
            {0.0, 0.0, 0.25}, {0.0, 0.0, 0.12}, {0.0, 1.0, 0.0});
        _viewer.getCamera()->setFinalDrawCallback(_grabber);
        _viewer.setSceneData(overlay);
    }

    /// Of the field focused on \a focus.
    osg::ref_ptr<osg::Image> picture(const Eigen::Vector3d& focus)
    {
        ++_frame;
        return picture(focusedOn(focus, *array, _frame));
    }
    osg::ref_ptr<osg::Image> silence()
    {
        ++_frame;
        const auto result = focusedOn({0.0, 0.0, 0.12}, *array, _frame);
        result->sequence.fields.front().setZero();
        return picture(result);
    }
    osg::ref_ptr<osg::Image> picture(const std::shared_ptr<bridge::HologramResult>& result)
    {
        // Twice: what draws is known, and a range has been found, only then.
        for (int pass = 0; pass < 2; ++pass)
        {
            OverlayPart::of(*overlay).setResult(result);
            overlay->waitFor(_frame, 60.0);
            _grabber->request();
            _viewer.frame();
        }
        return _grabber->image();
    }

    osg::ref_ptr<FieldSliceOverlay> overlay;
    std::shared_ptr<haptics::TransducerArray> array;
    bool able = false;
    std::string problem;

private:
    osgViewer::Viewer _viewer;
    osg::ref_ptr<samples::FrameGrabber> _grabber;
    std::uint64_t _frame = 0;
};

/// The shader's pictures are the thread's.
void expectAlike(Look& look)
{
    look.overlay->setRange(kRange_Pa); // one scale for both
    for (const Eigen::Vector3d& focus :
         {Eigen::Vector3d(0.005, -0.004, 0.12), Eigen::Vector3d(-0.012, 0.008, 0.115)})
    {
        look.overlay->setMethod(FieldSliceOverlay::CPU);
        const osg::ref_ptr<osg::Image> byThread = look.picture(focus);
        EXPECT_FALSE(look.overlay->isOnGpu());
        look.overlay->setMethod(FieldSliceOverlay::GPU);
        const osg::ref_ptr<osg::Image> byShader = look.picture(focus);
        EXPECT_TRUE(look.overlay->isOnGpu());
        ASSERT_TRUE(byThread && byShader);
        double sum = 0.0;
        int most = 0;
        int lit = 0;
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                for (int channel = 0; channel < 3; ++channel)
                {
                    const int a = byThread->data(x, y)[channel];
                    const int b = byShader->data(x, y)[channel];
                    sum += std::abs(a - b);
                    most = std::max(most, std::abs(a - b));
                    lit += a > 60 ? 1 : 0;
                }
        EXPECT_GT(lit, kSize * kSize / 4);
        // The thread is good to a percent of the peak; over the map's 256 steps a channel changes
        // by at most 2.6 a step.
        EXPECT_LT(sum / (3.0 * kSize * kSize), 1.0);
        EXPECT_LE(most, 2.0 + 2.6 * 256.0 * 0.01 * look.overlay->getPeakPressure() / kRange_Pa)
            << look.overlay->getPeakPressure();
    }
}

} // namespace

TEST(GpuSlice, ShowsWhatTheThreadShows)
{
    Look look;
    if (!look.able) GTEST_SKIP() << look.problem;
    expectAlike(look);
}

// Such a viewer has the number of an OpenGL context and none of its own; the next one gets it.
TEST(GpuSlice, IsRightAfterAViewerThatHadNoOpenGl)
{
    {
        const BoxScene box;
        HeadlessViewer viewer(box.scene);
        viewer.frame();
    }
    Look look;
    if (!look.able) GTEST_SKIP() << look.problem;
    expectAlike(look);
}

TEST(GpuSlice, SilenceIsDark)
{
    for (const auto method : {FieldSliceOverlay::CPU, FieldSliceOverlay::GPU})
    {
        Look look;
        if (!look.able) GTEST_SKIP() << look.problem;
        look.overlay->setMethod(method);
        const auto brightest = [](const osg::Image& image)
        {
            int most = 0;
            for (int y = 0; y < kSize; ++y)
                for (int x = 0; x < kSize; ++x)
                    for (int channel = 0; channel < 3; ++channel)
                        most = std::max<int>(most, image.data(x, y)[channel]);
            return most;
        };
        const osg::ref_ptr<osg::Image> before = look.silence();
        ASSERT_TRUE(before);
        EXPECT_GT(look.overlay->getNumChildren(), 0U) << "the disc is drawn";
        EXPECT_LT(brightest(*before), 64) << "before anything was played";
        EXPECT_GT(brightest(*look.picture({0.005, -0.004, 0.12})), 200);
        EXPECT_LT(brightest(*look.silence()), 64) << "after something was played";
    }
}

TEST(GpuSlice, SoftwareOpenGLKeepsTheThread)
{
    Look look;
    if (!look.able) GTEST_SKIP() << look.problem;
    look.picture({0.0, 0.0, 0.12});
    const char* renderer = std::getenv("LIBGL_ALWAYS_SOFTWARE");
    if (look.overlay->isOnGpu() && !renderer) GTEST_SKIP() << "a GPU draws here";
    EXPECT_FALSE(look.overlay->isOnGpu());
}

TEST(GpuSlice, TheEnvironmentDecides)
{
    Look look;
    if (!look.able) GTEST_SKIP() << look.problem;
    setenv("OSG_MIDAIR_SLICE", "gpu", 1);
    look.picture({0.0, 0.0, 0.12});
    EXPECT_TRUE(look.overlay->isOnGpu());
    setenv("OSG_MIDAIR_SLICE", "cpu", 1);
    look.overlay->setMethod(FieldSliceOverlay::GPU);
    look.picture({0.0, 0.0, 0.12});
    EXPECT_FALSE(look.overlay->isOnGpu());
    unsetenv("OSG_MIDAIR_SLICE");
}
