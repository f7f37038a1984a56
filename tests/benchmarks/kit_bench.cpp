// What the kit costs an application: collecting 10 haptic nodes out of 10,000 and handing a
// snapshot over, reading meshes, touching them, a scene in which nothing moves, and the time from a
// frame's stamp to the drive signal while a viewer draws.

#include "engine-bridge/pipeline/HologramThread.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/kit/Reading.h"
#include "tests/benchmarks/kit/Touching.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>
#include <thread>
#include <vector>

namespace
{

std::atomic<long> allocations{0};
thread_local bool counting = false;

} // namespace

// g++ takes the pairs below, once inlined, for mismatched ones.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

void* operator new(std::size_t size)
{
    if (counting) ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
    if (counting) ++allocations;
    return std::malloc(size);
}
void operator delete(void* memory) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

namespace
{

/// 10,000 nodes as \a branching children each, 10 of the leaves haptic.
struct BigScene
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    std::vector<osg::ref_ptr<osg::MatrixTransform>> movers;
    int nodes = 0;

    BigScene(int branching, bool tags)
    {
        scene->setDevice("null:");
        scene->setArray("board");
        osg::ref_ptr<osg::Node> shape = new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.02f));
        std::vector<osg::ref_ptr<osg::Group>> level{scene};
        while (nodes < 10000)
        {
            std::vector<osg::ref_ptr<osg::Group>> next;
            for (const auto& parent : level)
                for (int i = 0; i < branching && nodes < 10000; ++i, ++nodes)
                {
                    next.emplace_back(new osg::MatrixTransform);
                    parent->addChild(next.back());
                }
            level.swap(next);
        }
        for (int i = 0; i < 10; ++i)
        {
            osg::ref_ptr<osg::Group> haptic;
            if (tags)
            {
                haptic = new osg::Group;
                haptic->setUserValue("haptic", true);
            }
            else
                haptic = new osgMidair::HapticSurface;
            haptic->addChild(shape);
            movers.emplace_back(new osg::MatrixTransform);
            movers.back()->addChild(haptic);
            level[level.size() * static_cast<std::size_t>(i) / 10]->addChild(movers.back());
        }
    }

    void move(int frame)
    {
        for (std::size_t i = 0; i < movers.size(); ++i)
            movers[i]->setMatrix(osg::Matrixd::translate(
                0.025 * static_cast<double>(i) - 0.12, 1e-4 * (frame % 100), 0.15));
    }
};

void report(const char* what, const std::vector<double>& times_us, double perFrameAllocations)
{
    std::printf("%-44s median %7.1f us, p99 %7.1f us, %5.1f allocations a frame\n",
                what,
                midair::base::percentile(times_us, 0.5),
                midair::base::percentile(times_us, 0.99),
                perFrameAllocations);
}

void collect(const char* what, int branching, bool tags, bool moving)
{
    BigScene big(branching, tags);
    std::vector<double> times;
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    constexpr int kFrames = 1000;
    long before = 0;
    for (int frame = 0; frame < kFrames + 50; ++frame)
    {
        if (moving || frame == 0) big.move(frame);
        stamp->setFrameNumber(static_cast<unsigned int>(frame));
        if (frame == 50) before = allocations;
        const double start = midair::bench::cpu_us();
        counting = true;
        big.scene->update(stamp);
        counting = false;
        if (frame >= 50) times.push_back(midair::bench::cpu_us() - start);
    }
    report(what, times, static_cast<double>(allocations - before) / kFrames);
}

/// Paces frames at 60 a second.
class Pace
{
public:
    void wait()
    {
        _next += std::chrono::microseconds(16667);
        std::this_thread::sleep_until(_next);
    }

private:
    std::chrono::steady_clock::time_point _next = std::chrono::steady_clock::now();
};

/// Runs \a seconds of frames without drawing; CPU time of the whole process, all threads, in % of a
/// core.
double processShare(osg::Node* root, int seconds)
{
    osgViewer::Viewer viewer;
    viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
    viewer.setSceneData(root);
    Pace pace;
    const auto frames = [&](int count)
    {
        for (int i = 0; i < count; ++i, pace.wait())
        {
            viewer.advance();
            viewer.eventTraversal();
            viewer.updateTraversal();
        }
    };
    frames(60); // solved by then
    const double before = midair::bench::cpu_us(CLOCK_PROCESS_CPUTIME_ID);
    frames(60 * seconds);
    return (midair::bench::cpu_us(CLOCK_PROCESS_CPUTIME_ID) - before) / (1e6 * seconds) * 100.0;
}

osg::ref_ptr<osg::Node> box(float size_m)
{
    return new osg::ShapeDrawable(new osg::Box(osg::Vec3(), size_m));
}

void idle(int seconds)
{
    osg::ref_ptr<osg::Group> plain = new osg::Group;
    plain->addChild(box(0.04f));
    const double without = processShare(plain, seconds); // before any thread of the kit is there
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene; // octagon, simulated
    scene->addChild(new osgMidair::HapticSurface(box(0.04f).get()));
    const double with = processShare(scene, seconds);
    const osgMidair::HapticStatistics s = scene->getStatistics();
    std::printf(
        "idle scene, 60 frames/s for %d s: %.3f %% of a core with the kit, %.3f %% without: "
        "%.3f %%; %llu solves\n",
        seconds,
        with,
        without,
        with - without,
        static_cast<unsigned long long>(s.solves));
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    constexpr int kLooks = 2000;
    const double before_us = midair::bench::cpu_us();
    for (int i = 0; i < kLooks; ++i)
    {
        scene->setObstacles({}); // so that it doesn't rest
        scene->update(stamp);
    }
    std::printf("a full look at it, one after the other: %.2f us; at rest there are ten a second, "
                "each with cold caches\n",
                (midair::bench::cpu_us() - before_us) / kLooks);
    BigScene big(10, false);
    big.move(0);
    std::printf("idle scene of 10,000 nodes, 10 objects: %.3f %% of a core with the kit's viewer\n",
                processShare(big.scene, seconds));
}

/// A moving object of about 100 points in the octagonal array, drawn off screen at 60 frames a
/// second.
void motionToSignal(int seconds)
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    osg::ref_ptr<osg::MatrixTransform> mover = new osg::MatrixTransform;
    osg::ref_ptr<osgMidair::HapticSurface> surface = new osgMidair::HapticSurface(box(0.03f).get());
    surface->setSpacing(0.0061); // 100 points or so
    mover->addChild(surface);
    scene->addChild(mover);
    osgViewer::Viewer viewer;
    std::string error;
    if (!midair::samples::setUpOffscreen(viewer, 640, 480, 30.0, &error))
    {
        std::printf("motion to drive signal: no off-screen viewer (%s)\n", error.c_str());
        return;
    }
    viewer.setSceneData(scene);
    viewer.getCamera()->setViewMatrixAsLookAt(
        osg::Vec3d(0.0, -0.3, 0.1), osg::Vec3d(), osg::Vec3d(0.0, 0.0, 1.0));
    std::vector<double> above_ms;
    std::vector<double> solve_ms;
    std::shared_ptr<const midair::bridge::HologramResult> last;
    Pace pace;
    for (int frame = 0; frame < 60 * seconds; ++frame, pace.wait())
    {
        mover->setMatrix(osg::Matrixd::translate(
            0.02 * std::sin(0.05 * frame), 0.0, 0.02 * std::cos(0.031 * frame)));
        viewer.frame();
        const auto result = osgMidair::SceneAccess::latestResult(*scene);
        if (!result || result == last || frame < 60) continue;
        last = result;
        solve_ms.push_back(result->report().matrix_ms + result->report().solve_ms);
        above_ms.push_back(result->latency_ms - solve_ms.back());
    }
    if (above_ms.empty()) return;
    std::printf(
        "motion to drive signal, %d points, %zu fields: solve median %.2f ms; above it median "
        "%.2f ms, p99 %.2f ms\n",
        static_cast<int>(last->points.size()),
        above_ms.size(),
        midair::base::percentile(solve_ms, 0.5),
        midair::base::percentile(above_ms, 0.5),
        midair::base::percentile(above_ms, 0.99));
}

} // namespace

int main(int argc, char** argv)
{
    const int seconds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 10;
    collect("10,000 nodes, tree of 10, nothing moves", 10, false, false);
    collect("10,000 nodes, tree of 10, 10 objects move", 10, false, true);
    collect("10,000 nodes, one flat group, 10 move", 10000, false, true);
    collect("10,000 nodes, tree of 10, 10 tags move", 10, true, true);
    midair::bench::printReading();
    midair::bench::printTouching();
    idle(seconds);
    motionToSignal(seconds);
    return 0;
}
