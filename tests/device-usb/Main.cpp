#include "Preload.h"
#include "device/ArrayDevice.h"

#include <cstring>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace
{

// A program of its own for the test that kills it: opens the array that the test emulates and sends fields for ever.
int hostThatNeverCloses()
{
    using namespace midair::device;
    const auto device = openDevice("usb:", {8, {0, 0, 0, 0, 1, 1, 1, 1}});
    DriveSignal field;
    field.phase.assign(8, 1);
    field.duty.assign(8, 255);
    while (true)
    {
        device->send(field);
        ::usleep(5000);
    }
}

} // namespace

int main(int argc, char** argv)
{
    if (!restartWithUmockdev(argv)) return 1;
    spdlog::set_level(
        spdlog::level::off); // what is logged is in the report too, and there it is tested
    if (argc > 1 && std::strcmp(argv[1], "--host") == 0) return hostThatNeverCloses();
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
