#include "plugin/engine/SceneAccess.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticOverlays>

#include <osgViewer/CompositeViewer>

#include <atomic>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

const char* nameOf(osgViewer::ViewerBase::ThreadingModel model)
{
    switch (model)
    {
    case osgViewer::ViewerBase::SingleThreaded:
        return "SingleThreaded";
    case osgViewer::ViewerBase::CullDrawThreadPerContext:
        return "CullDrawThreadPerContext";
    case osgViewer::ViewerBase::DrawThreadPerContext:
        return "DrawThreadPerContext";
    default:
        return "CullThreadPerCameraDrawThreadPerContext";
    }
}

class ThreadingModels : public testing::TestWithParam<osgViewer::ViewerBase::ThreadingModel>
{
};

} // namespace

/// Two views, each with a context of its own, show one scene with all its overlays, while objects
/// move, come and go and another thread reads what the kit gives out. Meant for the sanitizers;
/// here it has to work.
TEST_P(ThreadingModels, TwoViewsOfAMovingSceneWithOverlays)
{
    BoxScene box;
    box.scene->addChild(new HapticOverlays);
    osg::ref_ptr<osg::MatrixTransform> second =
        new osg::MatrixTransform(osg::Matrixd::translate(0.05, 0.0, 0.15));
    second->addChild(box.surface);
    {
        osgViewer::CompositeViewer viewer;
        for (int i = 0; i < 2; ++i)
        {
            std::string error;
            osg::ref_ptr<osg::GraphicsContext> context =
                midair::samples::createOffscreenContext(160, 120, &error);
            if (!context) GTEST_SKIP() << error;
            osg::ref_ptr<osgViewer::View> view = new osgViewer::View;
            view->getCamera()->setGraphicsContext(context);
            view->getCamera()->setViewport(0, 0, 160, 120);
            view->getCamera()->setProjectionMatrixAsPerspective(40.0, 4.0 / 3.0, 0.01, 10.0);
            view->getCamera()->setViewMatrixAsLookAt(
                osg::Vec3d(0.3 * (i ? -1 : 1), -0.5, 0.3), osg::Vec3d(0.0, 0.0, 0.1), osg::Z_AXIS);
            view->setSceneData(box.scene);
            viewer.addView(view);
        }
        viewer.setThreadingModel(GetParam());
        viewer.realize();
        std::atomic<bool> stop{false};
        std::atomic<std::uint64_t> reads{0};
        std::thread reader(
            [&]
            {
                while (!stop)
                {
                    if (SceneAccess::latestResult(*box.scene) &&
                        box.scene->getStatistics().frames > 0)
                        ++reads;
                    std::this_thread::yield();
                }
            });
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        int frames = 0;
        while (frames < 60 ||
               ((reads == 0 || box.points() <= 0) && std::chrono::steady_clock::now() < end))
        {
            box.move(0.02 * std::sin(0.2 * frames));
            if (frames % 10 == 4) box.scene->addChild(second);
            if (frames % 10 == 8) box.scene->removeChild(second);
            if (frames == 30) box.scene->setTemperature(22.0); // another pipeline
            viewer.frame();
            ++frames;
        }
        stop = true;
        reader.join();
        EXPECT_GT(reads, 0u);
        EXPECT_EQ(box.scene->getStatistics().frames, static_cast<std::uint64_t>(frames))
            << "once a frame, not once a view";
        EXPECT_GT(box.points(), 0);
    }
    EXPECT_NE(box.scene->getStatistics().state, ArrayState::PLAYING) << "nobody leads it any more";
    EXPECT_GT(box.scene->getStatistics().solves, 1u);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    ThreadingModels,
    testing::Values(osgViewer::ViewerBase::SingleThreaded,
                    osgViewer::ViewerBase::CullDrawThreadPerContext,
                    osgViewer::ViewerBase::DrawThreadPerContext,
                    osgViewer::ViewerBase::CullThreadPerCameraDrawThreadPerContext),
    [](const auto& info) { return std::string(nameOf(info.param)); });
