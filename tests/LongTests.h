#pragma once

#include <cstdlib>
#include <string>

/// Whether tests that take many minutes are asked for: tests/run.sh --long sets
/// MIDAIR_LONG_TESTS=1, else 0.
inline bool longTestsAsked()
{
    const char* wanted = std::getenv("MIDAIR_LONG_TESTS");
    return wanted != nullptr && std::string(wanted) == "1";
}
