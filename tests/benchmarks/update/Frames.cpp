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

#include <sys/wait.h>
#include <unistd.h>

namespace midair::bench
{

namespace
{

constexpr int kRuns = 9; ///< of new balls
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
        {
            const std::size_t layer = i / 100;
            all[i]->setMatrix(
                osg::Matrixd::translate(0.01 * static_cast<double>(i % 10) - 0.045 + by_m,
                                        0.01 * static_cast<double>(i / 10 % 10) - 0.045,
                                        0.1 + 0.01 * static_cast<double>(layer)));
        }
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
std::vector<double> comeAtOnce_ms(int objects)
{
    Balls balls;
    balls.add(1, [] { return new osgMidair::HapticSurface(ball(0.004f).get()); });
    balls.update_ms();
    balls.add(objects, [] { return new osgMidair::HapticSurface(ball(0.004f).get()); });
    std::vector<double> times_ms;
    do
        times_ms.push_back(balls.update_ms());
    while (balls.scene->getStatistics().objects <= objects && times_ms.size() < 10000);
    return times_ms;
}

// The times of comeAtOnce_ms() in a process of its own, whose memory is new, too.
std::vector<double> inNewProcess_ms(int objects)
{
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("no process");
    if (child == 0)
    {
        std::FILE* out = ::fdopen(ends[1], "wb");
        for (const double time_ms : comeAtOnce_ms(objects))
            std::fwrite(&time_ms, sizeof time_ms, 1, out);
        std::fclose(out);
        ::_exit(0);
    }
    ::close(ends[1]);
    std::FILE* in = ::fdopen(ends[0], "rb");
    std::vector<double> times_ms;
    for (double time_ms = 0.0; std::fread(&time_ms, sizeof time_ms, 1, in) == 1;)
        times_ms.push_back(time_ms);
    std::fclose(in);
    ::waitpid(child, nullptr, 0);
    return times_ms;
}

// A frame does the same in each run: the median of its runs leaves out what else the machine did.
void comeAtOnce(int objects)
{
    std::vector<std::vector<double>> runs_ms;
    for (int run = 0; run < kRuns; ++run)
        runs_ms.push_back(inNewProcess_ms(objects));
    std::vector<double> times_ms;
    for (std::size_t frame = 0; frame < runs_ms.front().size(); ++frame)
    {
        std::vector<double> ofFrame_ms;
        for (const std::vector<double>& run_ms : runs_ms)
            if (frame < run_ms.size()) ofFrame_ms.push_back(run_ms[frame]);
        times_ms.push_back(median(ofFrame_ms));
    }
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
