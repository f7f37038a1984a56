#include <cstdlib>
#include <cstring>
#include <iostream>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

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
    ::testing::InitGoogleTest(&argc, argv);
    spdlog::set_level(
        spdlog::level::off); // what is logged is in the report too, and there it is tested
    return RUN_ALL_TESTS();
}
