#include "device/ArrayDevice.h"

#include <cstdlib>
#include <cstring>
#include <iostream>

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

// umockdev works by being loaded before libc: the program starts itself again with it. A sanitizer's runtime has to come first.
int main(int argc, char** argv)
{
    const char* loaded = std::getenv("LD_PRELOAD");
    if (loaded == nullptr || std::strstr(loaded, "umockdev") == nullptr)
    {
        const std::string sanitizer = MIDAIR_SANITIZER_RUNTIME;
        const std::string preload =
            sanitizer + (sanitizer.empty() ? "" : ":") + "libumockdev-preload.so.0";
        ::setenv("LD_PRELOAD", preload.c_str(), 1);
        ::execv("/proc/self/exe", argv);
        std::cerr << "can't start again with " << preload << ": " << std::strerror(errno) << "\n";
        return 1;
    }
    spdlog::set_level(
        spdlog::level::off); // what is logged is in the report too, and there it is tested
    if (argc > 1 && std::strcmp(argv[1], "--host") == 0) return hostThatNeverCloses();
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
