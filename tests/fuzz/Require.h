#pragma once

#include <cstdio>
#include <cstdlib>

/// Ends the program, as libFuzzer wants it, where a promise is broken.
inline void require(bool good, const char* what)
{
    if (good) return;
    std::fprintf(stderr, "broken: %s\n", what);
    std::abort();
}
