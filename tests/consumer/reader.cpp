#include <osgMidair/HapticScene>

#include <osgDB/ReadFile>

#include <chrono>
#include <iostream>
#include <thread>

/// reader SCENE ARRAY: reads a scene file and plays it on that array in the simulator.
int main(int argc, char** argv)
{
    if (argc != 3) return 2;
    const osg::ref_ptr<osgMidair::HapticScene> scene =
        osgDB::readRefFile<osgMidair::HapticScene>(argv[1]);
    if (!scene)
    {
        std::cerr << argv[1] << " isn't read as a HapticScene\n";
        return 1;
    }
    scene->setArray(argv[2]);
    scene->setDevice("sim:");
    scene->update(nullptr);
    for (int i = 0; i < 1000 && scene->getStatistics().solves == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    for (const std::string& message : scene->getStatistics().messages)
        std::cerr << message << "\n";
    std::cout << scene->getStatistics().points << " points of the scene file are played\n";
    return scene->getStatistics().points > 0 ? 0 : 1;
}
