#include "tests/benchmarks/headset/FrameCost.h"

#include "haptics/base/Percentile.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Xvfb.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/headset/Finger.h"
#include "tests/benchmarks/headset/Noted.h"

#include <osgMidair/HeadsetView>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bench
{

namespace
{

constexpr int kBlock = 135;      ///< frames one after the other, with haptics or without
constexpr int kLeftOut = 45;     ///< the first of them
constexpr double kFinger = 0.12; ///< m/s

/// Since it began, what this thread has run, and has waited for a processor; as Linux counts it.
double atWork_ms()
{
    std::ifstream file("/proc/thread-self/schedstat");
    double run_ns = 0.0, waited_ns = 0.0;
    file >> run_ns >> waited_ns;
    return 1e-6 * (run_ns + waited_ns);
}

/// What frames took their own thread.
struct Frames
{
    std::vector<double> cpu_ms;
    std::vector<double> asleep_ms; ///< waiting for something other than a processor

    void time(const std::function<void()>& frame, bool counts)
    {
        const double atWork = atWork_ms();
        const double wall = wall_ms();
        const double cpu = bench::cpu_ms();
        frame();
        const double cpuTaken_ms = bench::cpu_ms() - cpu;
        const double taken_ms = wall_ms() - wall;
        if (!counts) return;
        cpu_ms.push_back(cpuTaken_ms);
        asleep_ms.push_back(std::max(0.0, taken_ms - (atWork_ms() - atWork)));
    }
};

/// A block that a finger touches, and a ball that moves beside it.
struct Shown
{
    explicit Shown(bool isFelt, const char* solver = "")
    {
        osg::ref_ptr<osg::Node> ball = new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.01F));
        osg::ref_ptr<osg::Node> touched = block(topIn("octagon"));
        mover->addChild(ball);
        if (isFelt)
        {
            osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
            scene->setDevice("noted:");
            scene->setHands("openxr:");
            if (*solver) scene->setSolver(solver);
            osg::ref_ptr<osgMidair::HapticSurface> surface =
                new osgMidair::HapticSurface(touched.get());
            surface->setRender(osgMidair::HapticProperty::CONTACT);
            touched = surface;
            mover->removeChild(ball);
            mover->addChild(new osgMidair::HapticSurface(ball.get()));
            root = scene;
        }
        root->addChild(touched);
        root->addChild(mover);
    }
    void move()
    {
        const double t = base::steadySeconds();
        mover->setMatrix(
            osg::Matrixd::translate(0.04 * std::cos(7.5 * t), 0.04 * std::sin(7.5 * t), 0.04));
    }

    osg::ref_ptr<osg::Group> root = new osg::Group;
    osg::ref_ptr<osg::MatrixTransform> mover = new osg::MatrixTransform;
};

void printBoth(const char* what, const Frames& with, const Frames& without)
{
    const double with_ms = median(with.cpu_ms);
    const double without_ms = median(without.cpu_ms);
    std::printf("%-34s median %6.3f ms with haptics, %6.3f ms without: %+6.3f ms; 95 %% %6.3f ms, "
                "%6.3f ms\n",
                what,
                with_ms,
                without_ms,
                with_ms - without_ms,
                base::percentile(with.cpu_ms, 0.95),
                base::percentile(without.cpu_ms, 0.95));
}

// Events and updates; in turn, so that the machine is the same for both.
void traversals(int rounds, const char* solver, const char* what)
{
    Shown felt(true, solver), plain(false);
    Frames90 feltFrames(felt.root), plainFrames(plain.root);
    Frames with, without;
    const auto turn = [](Shown& shown, Frames90& frames, Frames& figures, int count, int leftOut)
    {
        for (int i = 0; i < count; ++i)
        {
            frames.wait();
            shown.move();
            figures.time([&] { frames.traverse(); }, i >= leftOut);
        }
    };
    for (int round = 0; round < rounds; ++round)
    {
        turn(felt, feltFrames, with, kBlock, kLeftOut);
        turn(plain, plainFrames, without, kBlock, kLeftOut);
    }
    printBoth(what, with, without);
    std::printf("%-34s longest %6.3f ms with haptics, %6.3f ms without; asleep at most %.3f ms, "
                "%.3f ms\n",
                "",
                base::percentile(with.cpu_ms, 1.0),
                base::percentile(without.cpu_ms, 1.0),
                base::percentile(with.asleep_ms, 1.0),
                base::percentile(without.asleep_ms, 1.0));
}

void inHeadset(int rounds)
{
    Shown felt(true), plain(false);
    osgViewer::Viewer viewer;
    viewer.setUpViewInWindow(0, 0, 160, 120);
    viewer.setSceneData(plain.root);
    std::string error;
    const auto headset = osgMidair::HeadsetView::open("openxr:", error);
    if (!headset || !headset->attach(viewer, error))
    {
        std::printf("in a headset: %s\n", error.c_str());
        return;
    }
    viewer.realize();
    Frames with, without;
    const auto turn = [&](Shown& shown, Frames& figures)
    {
        viewer.setSceneData(shown.root);
        for (int i = 0; i < kBlock; ++i)
        {
            shown.move();
            figures.time([&] { viewer.frame(); }, i >= kLeftOut);
        }
    };
    for (int round = 0; round < rounds; ++round)
    {
        turn(plain, without);
        turn(felt, with);
    }
    printBoth("in a headset, drawn by Mesa", with, without);
}

} // namespace

void printFrameCost(int rounds)
{
    useFakeRuntime();
    setFinger(topIn("octagon"), kFinger);
    setSolver_ms(50.0);
    traversals(rounds, "", "events and updates");
    traversals(rounds, "foci-works", "the same, a solver of 50 ms");
    if (!useXvfb())
    {
        std::printf("in a headset: there is no Xvfb\n");
        return;
    }
    useFakeRuntime();
    {
        const FakeAccess fake;
        fake->extensions = {"XR_EXT_hand_tracking",
                            "XR_KHR_convert_timespec_time",
                            "XR_KHR_opengl_enable",
                            "XR_KHR_composition_layer_depth"};
        fake->head = XrPosef{{0.0F, 0.0F, 0.0F, 1.0F}, {0.02F, 0.2F, 0.4F}};
        fake->keepsPictures = false;
        fake->isPaced = true;
    }
    setFinger(topIn("octagon"), kFinger);
    inHeadset(rounds);
}

} // namespace midair::bench
