// Array and device: a file names the array, a URI names the device and its limits. Here a flat
// board of 249 transducers in the simulator, at half of full drive.

#include "Frames.h"

#include <osgMidair/HapticPoints>

#include <algorithm>

int main(int argc, char** argv)
{
    // "octagon" is the default. `midair-solve --help` lists the others; a JSON file works, too.
    const char* const array = argc > 1 ? argv[1] : "board";
    // Hardware: "usb:", "autd3:", "sonicsurface:/dev/ttyUSB0". All accept the same limits.
    const char* const device = argc > 2 ? argv[2] : "sim:?max-amplitude=0.5&ramp=20ms";

    const osg::ref_ptr<osgMidair::HapticPoints> point = new osgMidair::HapticPoints;
    point->setPoints({osg::Vec3d(0.0, 0.0, 0.15)}); // m, above the centre of the board

    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setArray(array);
    scene->setDevice(device);
    scene->setTemperature(24.0); // of the air, C; one degree changes the wavelength by 1/500
    scene->addChild(point);

    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    frames.run(0.5); // until the ramp is over
    const osg::ref_ptr<const osgMidair::HapticField> field = scene->getField();
    if (!field) return 1;
    float most = 0.0F;
    for (const std::complex<float>& q : field->getActivations())
        most = std::max(most, std::abs(q));
    const osgMidair::HapticStatistics now = scene->getStatistics();
    std::printf("%s, %zu transducers: %s, amplitude up to %.2f, wavelength %.2f mm\n",
                array,
                field->getActivations().size(),
                stateName(now.state),
                most,
                1e3 * field->getWavelength());
    std::printf("%.0f Pa at %s\n", now.level_Pa, now.device.c_str());
    return 0;
}
