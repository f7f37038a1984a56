#pragma once

#include <cstdlib>
#include <string>

/// The program that runs this one on a processor of another kind (tests/arm64/run.sh names it), or
/// null where none is needed. It has to be named to start a program that was built with this one.
inline const char* emulatorOfTests()
{
    return std::getenv("MIDAIR_TEST_EMULATOR");
}

/// What a shell takes to start \a program.
inline std::string startOf(const std::string& program)
{
    const char* emulator = emulatorOfTests();
    return emulator != nullptr ? emulator + (" " + program) : program;
}
