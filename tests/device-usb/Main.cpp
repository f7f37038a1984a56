#include "device/ArrayDevice.h"
#include "tests/Eventually.h"
#include "tests/device-usb/Preload.h"

#include <csignal>
#include <cstring>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace
{

using namespace midair::device;

DriveSignal loudField(int transducers)
{
    DriveSignal field;
    field.phase.assign(transducers, 1);
    field.duty.assign(transducers, 255);
    return field;
}

// A program of its own for the test that kills it: opens the array that the test emulates and sends
// fields for ever.
int hostThatNeverCloses()
{
    const auto device = openDevice("usb:", {8, {0, 0, 0, 0, 1, 1, 1, 1}});
    while (true)
    {
        device->send(loudField(8));
        letPass(5e-3);
    }
}

// The same for the board behind an FT232H, but it sends one field and stops itself. Its child
// speaks to the emulation on the very connection that it leaves, and the answer to a request that
// it was killed in would be taken for the answer to the child's.
int fifoHostThatNeverCloses()
{
    const auto device = openDevice("openmpd:A0001", {256, {}});
    device->send(loudField(256));
    eventually([&] { return device->report().played > 0; });
    ::raise(SIGSTOP);
    return 1;
}

} // namespace

int main(int argc, char** argv)
{
    if (!restartWithUmockdev(argv)) return 1;
    spdlog::set_level(
        spdlog::level::off); // what is logged is in the report too, and there it is tested
    const char* argument = argc > 1 ? argv[1] : "";
    if (std::strcmp(argument, "--host") == 0) return hostThatNeverCloses();
    if (std::strcmp(argument, "--fifo-host") == 0) return fifoHostThatNeverCloses();
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
