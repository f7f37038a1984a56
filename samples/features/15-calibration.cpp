// Calibration: points measured by the tracker and in the array's frame determine where the array is
// in the world. Here they are simulated, with 0.5 mm of noise and one wrong pair.

#include "Frames.h"

#include <osgMidair/Calibration>
#include <osgMidair/HapticPoints>

#include <random>

int main()
{
    // The array is 1.2 m above the floor and rotated by 30 degrees.
    const osg::Matrixd truth = osg::Matrixd::translate(0.3, -0.1, -1.2) *
                               osg::Matrixd::rotate(osg::PI / 6.0, osg::Vec3d(0, 0, 1));
    const osg::Matrixd arrayToWorld = osg::Matrixd::inverse(truth);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-0.15, 0.15);
    std::normal_distribution<double> noise(0.0, 0.0005);
    osgMidair::PointPairs pairs; // or readPointPairs() from a file
    for (int i = 0; i < 14; ++i)
    {
        const osg::Vec3d spot(place(random), place(random), place(random));
        const osg::Vec3d error(noise(random), noise(random), noise(random));
        pairs.array.push_back(spot);
        pairs.world.push_back(spot * arrayToWorld + error);
    }
    pairs.world[5].x() += 0.06;

    const osgMidair::CalibrationReport report = osgMidair::calibrate(pairs.world, pairs.array);
    std::printf("%s", report.text.c_str());
    if (!report.usable) return 1;

    // Now the world is the tracker's. Place an object at the centre of the array.
    const osg::ref_ptr<osgMidair::HapticPoints> point = new osgMidair::HapticPoints;
    point->setPoints({osg::Vec3d() * arrayToWorld});
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setCalibration(report.worldToArray);
    scene->addChild(point);
    const osg::ref_ptr<const osgMidair::HapticField> field = Frames(*scene).untilPlayed();
    if (!field || field->getPoints().size() != 1) return 1;
    const osg::Vec3d world = field->getPoints().front().position;
    std::printf("played at (%.2f, %.2f, %.2f) m of the world, %.1f mm from the array's middle\n",
                world.x(),
                world.y(),
                world.z(),
                1e3 * (world * field->getWorldToArray()).length());
    return 0;
}
