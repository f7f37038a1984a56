#pragma once

#include <array>
#include <cstdio>
#include <string>

#include <sys/wait.h>

/// What a command left behind.
struct Outcome
{
    int code = -1;
    std::string output; ///< stdout and stderr
};

/// Runs \a command as a user would type it.
inline Outcome shell(const std::string& command)
{
    Outcome outcome;
    FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    if (!pipe) return outcome;
    std::array<char, 4096> buffer{};
    while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe))
        outcome.output.append(buffer.data(), got);
    const int status = pclose(pipe);
    if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
    return outcome;
}
