#include "tests/benchmarks/kit/Reading.h"

#include "tests/benchmarks/Timing.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Geometry>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace midair::bench
{

namespace
{

/// A plate of side x side vertices, 100 mm wide.
struct Plate
{
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::DrawElementsUInt> quads = new osg::DrawElementsUInt(GL_QUADS);
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;

    explicit Plate(unsigned int side)
    {
        for (unsigned int j = 0; j < side; ++j)
            for (unsigned int i = 0; i < side; ++i)
                vertices->push_back(osg::Vec3d(0.1 * i / side - 0.05, 0.1 * j / side - 0.05, 0.15));
        for (unsigned int j = 0; j + 1 < side; ++j)
            for (unsigned int i = 0; i + 1 < side; ++i)
                for (const unsigned int v : {0U, 1U, side + 1U, side + 0U})
                    quads->push_back(j * side + i + v);
        geometry->setVertexArray(vertices);
        geometry->addPrimitiveSet(quads);
    }

    void wave(int frame)
    {
        const auto z = static_cast<float>(0.15 + 0.005 * std::sin(0.1 * frame));
        for (osg::Vec3& vertex : *vertices)
            vertex.z() = z;
    }
};

/// The time of each frame of a scene, and how many pass until all that is in it is read.
class Frames
{
public:
    Frames()
    {
        scene->setDevice("null:");
        scene->setArray("board");
    }

    void add(const Plate& plate)
    {
        scene->addChild(new osgMidair::HapticSurface(plate.geometry.get()));
    }

    void run()
    {
        stamp->setFrameNumber(stamp->getFrameNumber() + 1);
        const double start_us = midair::bench::cpu_us();
        scene->update(stamp);
        times_us.push_back(midair::bench::cpu_us() - start_us);
        std::this_thread::sleep_for(std::chrono::milliseconds(2)); // the hologram thread's turn
    }

    void print(const std::string& what, const std::string& after = "")
    {
        std::sort(times_us.begin(), times_us.end());
        std::printf("%-44s median %7.1f us, p99 %7.1f us, max %7.1f us%s\n",
                    what.c_str(),
                    times_us[times_us.size() / 2],
                    times_us[times_us.size() * 99 / 100],
                    times_us.back(),
                    after.c_str());
        times_us.clear();
    }

    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    std::vector<double> times_us;
};

/// Frames until each of some new plates of \a side x side vertices is read, \a count at once.
void printNew(const std::string& what, unsigned int side, int count)
{
    Frames frames;
    for (int i = 0; i < 10; ++i)
        frames.run();
    frames.times_us.clear();
    int most = 0;
    for (int round = 0; round < 20; ++round)
    {
        std::vector<Plate> plates;
        for (int i = 0; i < count; ++i)
            plates.emplace_back(side);
        frames.scene->removeChildren(0, frames.scene->getNumChildren());
        for (const Plate& plate : plates)
            frames.add(plate);
        int needed = 0;
        do
            frames.run();
        while (++needed < 1000 && frames.scene->getStatistics().objects < count);
        most = std::max(most, needed);
    }
    frames.print(what, ", felt in frame " + std::to_string(most));
}

/// Frames in each of which \a change happens to a plate of \a side x side vertices.
void printChanged(const std::string& what,
                  unsigned int side,
                  const std::function<void(Plate&, int frame)>& change)
{
    Plate plate(side);
    Frames frames;
    frames.add(plate);
    for (int i = 0; i < 20; ++i)
        frames.run();
    frames.times_us.clear();
    for (int frame = 0; frame < 300; ++frame)
    {
        change(plate, frame);
        frames.run();
    }
    frames.print(what);
}

} // namespace

void printReading()
{
    for (const unsigned int side : {45U, 256U})
    {
        const std::string size = std::to_string(side * side) + " vertices, ";
        printNew(size + "new", side, 1);
        printChanged(size + "nothing moves", side, [](Plate&, int) {});
        printChanged(size + "all move",
                     side,
                     [](Plate& plate, int frame)
                     {
                         plate.wave(frame);
                         plate.vertices->dirty();
                     });
        printChanged(size + "all move without dirty()",
                     side,
                     [](Plate& plate, int frame) { plate.wave(frame); });
        printChanged(size + "all said to be new now and then",
                     side,
                     [](Plate& plate, int frame)
                     {
                         if (frame % 10 != 0) return;
                         plate.vertices->dirty();
                         plate.quads->dirty();
                     });
    }
    printNew("10 x 20,164 vertices, new at once", 142, 10);
}

} // namespace midair::bench
