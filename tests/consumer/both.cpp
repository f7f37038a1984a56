// The kit and libmidair's C++ in one program. A device has one owner, and what a program writes
// into its own variables is no word of the user's.
#include "device/ArrayDevice.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/ShapeDrawable>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <thread>

namespace
{

osg::ref_ptr<osgMidair::HapticScene> box(const std::string& device)
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.03f))));
    scene->setArray("board");
    scene->setDevice(device);
    scene->update(nullptr);
    return scene;
}

bool becomes(osgMidair::HapticScene& scene,
             const std::function<bool(const osgMidair::HapticStatistics&)>& wanted)
{
    for (int i = 0; i < 1000 && !wanted(scene.getStatistics()); ++i)
    {
        scene.update(nullptr);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return wanted(scene.getStatistics());
}

int fail(const std::string& what)
{
    std::cerr << what << "\n";
    return 1;
}

} // namespace

/// both FILE: FILE is where a recording goes.
int main(int argc, char** argv)
{
    if (argc != 2) return 2;
    const std::string uri = std::string("record:") + argv[1];
    // NOLINTNEXTLINE(concurrency-mt-unsafe): no thread runs yet
    setenv("OSG_MIDAIR_DEVICE", "null:", 1);

    auto owned = midair::device::openDevice(uri, {256, {}});
    const osg::ref_ptr<osgMidair::HapticScene> scene = box(uri);
    const auto namesTheFile = [&](const osgMidair::HapticStatistics& now)
    {
        for (const std::string& message : now.messages)
            if (message.find(argv[1]) != std::string::npos) return true;
        return false;
    };
    if (!becomes(*scene, namesTheFile)) return fail("the kit doesn't say that the file is in use");
    if (scene->getStatistics().fields.played != 0) return fail("the kit plays into that file");
    std::cout << "told: " << scene->getStatistics().messages.front() << "\n";

    const osg::ref_ptr<osgMidair::HapticScene> simulated = box("sim:");
    if (!becomes(*simulated,
                 [](const osgMidair::HapticStatistics& now) { return now.fields.played > 0; }))
        return fail("the kit doesn't play in the simulator");
    if (simulated->getStatistics().device.rfind("sim:", 0) != 0)
        return fail("the kit takes a device that the program wrote into its variables: " +
                    simulated->getStatistics().device);
    return 0;
}
