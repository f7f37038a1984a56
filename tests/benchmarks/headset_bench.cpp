// What a headset asks of the kit: how old joints are when the drive signal that follows from them
// is handed to the device, what haptics cost a frame, and how far a moving ball is played from
// where it is seen. Frames come 90 times a second; hands are an OpenXR runtime's of the tests.

#include "tests/benchmarks/headset/FrameCost.h"
#include "tests/benchmarks/headset/JointToDrive.h"
#include "tests/benchmarks/headset/Noted.h"
#include "tests/benchmarks/headset/SeenAndPlayed.h"

#include <osg/Notify>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>

namespace
{

/// What the figures are of: the processor, and how busy others keep it.
void printMachine()
{
    std::ifstream info("/proc/cpuinfo");
    std::string line;
    while (std::getline(info, line) && line.rfind("model name", 0) != 0)
        continue;
    std::array<double, 1> load{};
    getloadavg(load.data(), 1);
    std::printf("%u cores, %s; load %.1f as it begins\n",
                std::thread::hardware_concurrency(),
                line.c_str(),
                load[0]);
}

int run(int argc, char** argv)
{
    CLI::App app("Measures what a headset requires of the kit.");
    double seconds = 10.0;
    std::string part;
    app.add_option("--seconds", seconds, "duration of each measurement, s")
        ->check(CLI::Range(2.0, 600.0));
    app.add_option("PART", part, "run only this part")
        ->check(CLI::IsMember({"joints", "frames", "motion"}));
    CLI11_PARSE(app, argc, argv);
    osg::setNotifyLevel(osg::ALWAYS); // figures alone
    midair::bench::registerNoted();
    printMachine();
    if (part.empty() || part == "joints")
    {
        std::printf("from joint to drive, the joints' age as a field is handed to the device\n");
        for (const char* array : {"octagon", "board"})
            midair::bench::printJointToDrive(array, seconds);
    }
    if (part.empty() || part == "frames")
    {
        std::printf("a frame, processor time of its own thread\n");
        midair::bench::printFrameCost(static_cast<int>(seconds / 2.0));
    }
    if (part.empty() || part == "motion")
    {
        std::printf("a ball at 0.3 m/s, from where it is seen to where it is played, median "
                    "(95 %%)\n");
        midair::bench::printSeenAndPlayed(seconds);
    }
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-headset-bench: %s\n", error.what());
        return 1;
    }
}
