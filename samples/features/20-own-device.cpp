// A custom device: a driver that receives levels for each transducer, registered with a scheme.
// Limits, mutes and caps apply as for any other device.

#include "Frames.h"

#include <osgMidair/DeviceDriver>
#include <osgMidair/HapticPoints>

#include <algorithm>
#include <atomic>

namespace
{

std::atomic<int> transducersOn{0};

/// Stands for a board with its own driver: 64 phases, each transducer on or off.
class DeskDriver : public osgMidair::DeviceDriver
{
public:
    bool open(const std::string& path,
              const std::map<std::string, std::string>& options,
              const Layout& layout,
              std::string& error) override
    {
        _transducers = layout.transducers;
        if (!path.empty() || !options.empty()) error = "takes no path and no parameters";
        return error.empty();
    }
    bool play(const unsigned char* /*phases*/, const unsigned char* amplitudes) override
    {
        // A real driver would send the levels to the board here.
        transducersOn = static_cast<int>(
            std::count(amplitudes, amplitudes + _transducers, static_cast<unsigned char>(1)));
        return true;
    }
    void silence() override { transducersOn = 0; } // throw if it fails
    std::string getStatus() const override { return "the board on the desk"; }
    unsigned int getPhaseLevels() const override { return 64; }
    std::vector<float> getAmplitudes() const override { return {0.0F, 1.0F}; }

private:
    unsigned int _transducers = 0;
};

} // namespace

int main()
{
    std::string error;
    if (!osgMidair::registerDevice(
            "desk", [] { return osg::ref_ptr<osgMidair::DeviceDriver>(new DeskDriver); }, error))
    {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 1;
    }
    const osg::ref_ptr<osgMidair::HapticPoints> point = new osgMidair::HapticPoints;
    point->setPoints({osg::Vec3d(0.0, 0.0, 0.15)});
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setArray("board");
    scene->setDevice("desk:"); // users write -O device=desk: or OSG_MIDAIR_DEVICE=desk:
    scene->addChild(point);

    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    std::printf(
        "%d transducers on, %s\n", transducersOn.load(), scene->getStatistics().device.c_str());
    scene->setMuted(true);
    frames.run(0.3);
    std::printf("muted: %d on\n", transducersOn.load());
    return transducersOn == 0 ? 0 : 1;
}
