#pragma once

#include <cstdlib>

/// The program that runs this one on a processor of another kind (tests/arm64/run.sh names it), or
/// null where none is needed. It has to be named to start this program once more.
inline const char* emulatorOfTests()
{
    return std::getenv("MIDAIR_TEST_EMULATOR");
}
