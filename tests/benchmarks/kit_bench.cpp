// What the kit costs the update thread: collecting 10 haptic nodes out of 10,000, and handing a snapshot over.

#include "engine-bridge/HologramThread.h"
#include "plugin/HapticEngine.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <thread>
#include <vector>

#include <time.h>

namespace
{

std::atomic<long> allocations{0};
thread_local bool counting = false;

/// Time of this thread alone, so that a busy machine does not count.
double threadTime_us()
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

} // namespace

// g++ takes the pairs below, once inlined, for mismatched ones.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

void* operator new(std::size_t size)
{
    if (counting) ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
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

void report(const char* what, std::vector<double>& times_us, double perFrameAllocations)
{
    std::sort(times_us.begin(), times_us.end());
    std::printf("%-44s median %7.1f us, p99 %7.1f us, %5.1f allocations a frame\n",
                what,
                times_us[times_us.size() / 2],
                times_us[times_us.size() * 99 / 100],
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
        const double start = threadTime_us();
        counting = true;
        big.scene->update(stamp);
        counting = false;
        if (frame >= 50) times.push_back(threadTime_us() - start);
    }
    report(what, times, static_cast<double>(allocations - before) / kFrames);
}

} // namespace

int main()
{
    collect("10,000 nodes, tree of 10, nothing moves", 10, false, false);
    collect("10,000 nodes, tree of 10, 10 objects move", 10, false, true);
    collect("10,000 nodes, one flat group, 10 move", 10000, false, true);
    collect("10,000 nodes, tree of 10, 10 tags move", 10, true, true);
    return 0;
}
