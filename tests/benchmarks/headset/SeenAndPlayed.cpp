#include "tests/benchmarks/headset/SeenAndPlayed.h"

#include "haptics/base/Percentile.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/headset/Noted.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace midair::bench
{

namespace
{

using Eigen::Vector3d;

constexpr double kSpeed = 0.3;
constexpr double kLight_s = 0.022; ///< from a frame's time to its light
constexpr double kRise_s = 0.2e-3; ///< of a transducer's amplitude
constexpr double kSound = 343.2;
constexpr double kHeight_m = 0.2;

/// Where a ball is drawn in the frame of a time.
struct Way
{
    const char* name;
    Vector3d (*at)(double time_s);
    bool (*counts)(double time_s); ///< the times that are looked at
};

Vector3d onCircle(double t)
{
    constexpr double kRadius_m = 0.04;
    const double angle = kSpeed * t / kRadius_m;
    return {kRadius_m * std::cos(angle), kRadius_m * std::sin(angle), kHeight_m};
}

constexpr double kPass_s = 0.5;
constexpr double kPasses_s = 1.6; ///< there, a rest, back, a rest
constexpr double kEnd_m = 0.5 * kSpeed * kPass_s;

/// From one end to the other, with a rest at each.
Vector3d onLine(double t)
{
    const double phase_s = std::fmod(t, kPasses_s);
    const bool isBack = phase_s > 0.5 * kPasses_s;
    const double way_m = kSpeed * std::min(std::fmod(phase_s, 0.5 * kPasses_s), kPass_s);
    return {isBack ? kEnd_m - way_m : way_m - kEnd_m, 0.0, kHeight_m};
}

/// From a quarter of a second after it has started.
bool isOnItsWay(double t)
{
    const double pass_s = std::fmod(t, 0.5 * kPasses_s);
    return pass_s > 0.25 && pass_s < kPass_s;
}

struct Ball
{
    Ball(const char* solver, bool carriesOn)
    {
        scene->setDevice("noted:");
        scene->setArray("board");
        scene->setExtrapolate(carriesOn);
        if (*solver) scene->setSolver(solver);
        mover->addChild(new osgMidair::HapticSurface(
            new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 2.2e-3F))));
        scene->addChild(mover);
    }
    void move(double time_s, const Vector3d& to)
    {
        mover->setMatrix(osg::Matrixd::translate(to.x(), to.y(), to.z()));
        scene->setDisplayTime(time_s + kLight_s);
    }

    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    osg::ref_ptr<osg::MatrixTransform> mover = new osg::MatrixTransform;
};

struct Heard
{
    double time_s = 0.0;
    Vector3d place = Vector3d::Zero();
};

/// When the fields are heard, and where they are loudest.
std::vector<Heard> heardOf(const std::vector<NotedDrive>& drives, const Way& way)
{
    const FocusFinder finder(haptics::TransducerArray::load("board"), kSound / 40e3);
    std::vector<Heard> all;
    for (const NotedDrive& drive : drives)
        if (const auto found = finder.near(drive, way.at(drive.time_s - kLight_s)))
            all.push_back({drive.time_s + kRise_s + found->norm() / kSound, *found});
    return all;
}

double percent95(const std::vector<double>& values)
{
    return base::percentile(values, 0.95);
}

void printOne(const Way& way, const char* name, const char* solver, bool carriesOn, double seconds)
{
    Ball ball(solver, carriesOn);
    Frames90 frames(ball.scene);
    std::vector<double> lit_s; // times for which frames were drawn
    const auto move = [&](double time_s)
    {
        ball.move(time_s, way.at(time_s));
        lit_s.push_back(time_s);
    };
    frames.framesFor(1.5, move);
    takeDrives();
    frames.framesFor(seconds, move);
    const auto told = ball.scene->getStatistics().coincidence;
    const double told_mm = told.empty() ? 0.0 : told[0].motion.median_mm;
    const std::vector<Heard> heard = heardOf(takeDrives(), way);
    std::vector<double> arriving_mm, held_mm;
    for (std::size_t i = 0; i < heard.size(); ++i)
    {
        const double seen_s = heard[i].time_s - kLight_s;
        if (!way.counts(seen_s)) continue;
        arriving_mm.push_back(1e3 * (heard[i].place - way.at(seen_s)).head<2>().norm());
        if (i + 1 == heard.size()) break;
        // And while it is held, against the frame whose light is there.
        for (double t = heard[i].time_s; t < heard[i + 1].time_s; t += 1e-3)
        {
            const auto next = std::upper_bound(lit_s.begin(), lit_s.end(), t - kLight_s);
            if (next == lit_s.begin() || !way.counts(t - kLight_s)) continue;
            held_mm.push_back(1e3 * (heard[i].place - way.at(*(next - 1))).head<2>().norm());
        }
    }
    std::printf("%-7s %-22s %-4s as the sound arrives %5.2f (%5.2f) mm; at all times %5.2f "
                "(%5.2f) mm; %4.0f fields a second; the kit says %.2f mm\n",
                way.name,
                name,
                carriesOn ? "on" : "off",
                median(arriving_mm),
                percent95(arriving_mm),
                median(held_mm),
                percent95(held_mm),
                static_cast<double>(heard.size()) / seconds,
                told_mm);
}

} // namespace

void printSeenAndPlayed(double seconds)
{
    const Way circle = {"circle", onCircle, [](double) { return true; }};
    const Way line = {"line", onLine, isOnItsWay};
    setSolver_ms(38.0);
    for (const Way& way : {line, circle})
        for (const char* solver : {"", "foci-sleeps"})
            for (const bool carriesOn : {false, true})
                printOne(way,
                         *solver ? "a solver of 38 ms" : "the kit's solver",
                         solver,
                         carriesOn,
                         seconds);
}

} // namespace midair::bench
