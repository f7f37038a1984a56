#include "tests/benchmarks/update/Frames.h"

#include "tests/benchmarks/Timing.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

namespace midair::bench
{

namespace
{

constexpr int kFrames = 200;

osg::ref_ptr<osg::Node> ball(float radius_m)
{
    return new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), radius_m));
}

/// Balls in rows, in the air above a board that nothing is sent to.
struct Balls
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    osg::ref_ptr<osg::Group> group = new osg::Group;
    std::vector<osg::ref_ptr<osg::MatrixTransform>> all;
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    unsigned int frame = 0;

    Balls()
    {
        scene->setDevice("null:");
        scene->setArray("board");
        scene->addChild(group);
    }

    /// \a make returns what is below the transform of each.
    template<class Make>
    void add(int count, const Make& make)
    {
        for (int i = 0; i < count; ++i)
        {
            all.emplace_back(new osg::MatrixTransform);
            all.back()->addChild(make());
            group->addChild(all.back());
        }
        move(0.0);
    }

    void move(double by_m)
    {
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i]->setMatrix(
                osg::Matrixd::translate(0.01 * static_cast<double>(i % 10) - 0.045 + by_m,
                                        0.01 * static_cast<double>(i / 10 % 10) - 0.045,
                                        0.1 + 0.01 * static_cast<double>(i / 100)));
    }

    double update_ms()
    {
        stamp->setFrameNumber(++frame);
        const double begin_ms = cpu_ms();
        scene->update(stamp);
        return cpu_ms() - begin_ms;
    }
};

void printTimes(const char* what, int objects, std::vector<double> times_ms)
{
    const double longest_ms = *std::max_element(times_ms.begin(), times_ms.end());
    std::printf("%-36s %5d %9.3f %9.3f %7zu\n",
                what,
                objects,
                median(times_ms),
                longest_ms,
                times_ms.size());
}

// The first frame is left out: it opens the device and reads the array.
void comeAtOnce(int objects)
{
    Balls balls;
    balls.add(1, [] { return new osgMidair::HapticSurface(ball(0.004f).get()); });
    balls.update_ms();
    balls.add(objects, [] { return new osgMidair::HapticSurface(ball(0.004f).get()); });
    std::vector<double> times_ms;
    do
        times_ms.push_back(balls.update_ms());
    while (balls.scene->getStatistics().objects <= objects && times_ms.size() < 10000);
    printTimes("new balls, until all are felt", objects, times_ms);
}

void standMoveAndRest(int objects)
{
    Balls balls;
    balls.add(objects, [] { return new osgMidair::HapticSurface(ball(0.004f).get()); });
    while (balls.scene->getStatistics().objects < objects)
        balls.update_ms();
    std::vector<double> moving_ms, still_ms, resting_ms;
    for (int i = 1; i <= kFrames; ++i)
    {
        balls.move(1e-4 * i);
        balls.scene->getBound();
        moving_ms.push_back(balls.update_ms());
    }
    for (int i = 0; i < kFrames / 10; ++i)
        still_ms.push_back(balls.update_ms());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    balls.update_ms();
    for (int i = 0; i < kFrames; ++i)
    {
        resting_ms.push_back(balls.update_ms());
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    printTimes("balls that move", objects, moving_ms);
    printTimes("balls that have just stopped", objects, still_ms);
    printTimes("balls at rest, 200 frames/s", objects, resting_ms);
}

/// Processor time of the process until there is a field of all.
template<class Make>
void firstField(const char* what, int objects, const Make& make)
{
    Balls balls;
    balls.update_ms();
    balls.add(objects, make);
    const double begin_ms = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
    do
    {
        balls.update_ms();
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    } while (balls.scene->getStatistics().objects < objects);
    while (balls.scene->getStatistics().processed < balls.scene->getStatistics().snapshots)
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    std::printf("%-36s %5d %9.1f\n", what, objects, cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - begin_ms);
}

} // namespace

void printFrames(int objects)
{
    std::printf("update() of an own loop, processor time\n%36s %5s %9s %9s %7s\n",
                "",
                "n",
                "median/ms",
                "most/ms",
                "frames");
    for (const int count : {200, objects})
        comeAtOnce(count);
    for (const int count : {200, objects})
        standMoveAndRest(count);
    std::printf("to the first field, processor time of all threads, ms\n");
    const auto drawable = ball(0.02f);
    const osg::ref_ptr<osg::Node> surface = new osgMidair::HapticSurface(drawable.get());
    firstField("one surface node at all places", 200, [&] { return surface; });
    firstField("surfaces that share a drawable",
               200,
               [&]
               { return osg::ref_ptr<osg::Node>(new osgMidair::HapticSurface(drawable.get())); });
    firstField(
        "surfaces with equal drawables",
        200,
        [] { return osg::ref_ptr<osg::Node>(new osgMidair::HapticSurface(ball(0.02f).get())); });
}

} // namespace midair::bench
