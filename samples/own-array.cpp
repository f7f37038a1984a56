// Sample without a window, with installed headers alone: an array of the program's own with a dead
// transducer, a device of its own that it is played on, and the field that is felt. Prints what the
// device gets and how the pressure falls off beside a point.

#include <osgMidair/ArrayDescription>
#include <osgMidair/DeviceDriver>
#include <osgMidair/HapticField>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <complex>
#include <cstdio>
#include <thread>

namespace
{

std::atomic<int> fieldsPlayed{0};
std::atomic<int> transducersOn{0};

/// Stands for a board with a driver of its own: 64 phases, each transducer off or on.
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
        // Here the levels would go to the board.
        transducersOn = static_cast<int>(
            std::count(amplitudes, amplitudes + _transducers, static_cast<unsigned char>(1)));
        ++fieldsPlayed;
        return true;
    }
    void silence() override { transducersOn = 0; }
    std::string getStatus() const override { return "the board on the desk"; }
    unsigned int getPhaseLevels() const override { return 64; }
    std::vector<float> getAmplitudes() const override { return {0.0F, 1.0F}; }

private:
    unsigned int _transducers = 0;
};

/// Two boards of 10 x 10 that face each other, 300 mm apart, of which one transducer is dead.
osgMidair::ArrayDescription deskArray()
{
    osgMidair::ArrayDescription array;
    array.name = "desk";
    array.addGrid(osg::Vec3d(0, 0, -0.15), osg::Z_AXIS, osg::X_AXIS, 10, 10, 0.0105);
    array.addGrid(osg::Vec3d(0, 0, 0.15), -osg::Z_AXIS, osg::X_AXIS, 10, 10, 0.0105);
    array.dead = {42};
    return array;
}

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
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setArrayDescription(deskArray());
    scene->setDevice("desk:");
    const osg::ref_ptr<osgMidair::HapticSurface> box = new osgMidair::HapticSurface;
    box->setSampling(osgMidair::HapticProperty::VERTICES);
    box->addChild(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.03F)));
    scene->addChild(box);

    scene->update(nullptr); // what a viewer does in each frame
    osg::ref_ptr<const osgMidair::HapticField> field;
    for (int i = 0; i < 1000 && !(field = scene->getField()); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (!field || !field->isPlaying() || field->getPoints().empty())
    {
        for (const std::string& message : scene->getStatistics().messages)
            std::fprintf(stderr, "%s\n", message.c_str());
        return 1;
    }
    const osgMidair::HapticField::ControlPoint& point = field->getPoints().front();
    std::printf("%d of %zu transducers play %zu points\n",
                transducersOn.load(),
                field->getActivations().size(),
                field->getPoints().size());
    std::printf("at (%.0f, %.0f, %.0f) mm: %.0f Pa wanted\n",
                1e3 * point.position.x(),
                1e3 * point.position.y(),
                1e3 * point.position.z(),
                point.wanted_Pa);
    for (int mm = 0; mm <= 6; mm += 2)
        std::printf("%d mm beside it: %.0f Pa\n",
                    mm,
                    std::abs(field->getPressure(point.position + osg::X_AXIS * (1e-3 * mm))));
    return transducersOn == 199 ? 0 : 1;
}
