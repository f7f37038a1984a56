#pragma once

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <unistd.h>

/// umockdev works by being loaded before libc: starts the program again with it, unless it is. A
/// sanitizer's runtime has to come first. Returns false when that is not possible.
inline bool restartWithUmockdev(char** argv)
{
    const char* loaded = std::getenv("LD_PRELOAD");
    if (loaded != nullptr && std::strstr(loaded, "umockdev") != nullptr) return true;
    const std::string sanitizer = MIDAIR_SANITIZER_RUNTIME;
    const std::string preload =
        sanitizer + (sanitizer.empty() ? "" : ":") + "libumockdev-preload.so.0";
    ::setenv("LD_PRELOAD", preload.c_str(), 1);
    ::execv("/proc/self/exe", argv);
    std::fprintf(stderr, "can't start again with %s: %s\n", preload.c_str(), std::strerror(errno));
    return false;
}
