#pragma once

#include "tests/Eventually.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

/// How a program ended that got a signal.
struct Ending
{
    double seconds = 0.0; ///< from the signal on
    double busy_s = 0.0;  ///< of these: in which this process wasn't run either, added up
    int signal = 0;       ///< that ended it; 0: it ended by itself
    int code = -1;
    std::string said;
};

/// Runs \a program in a process of its own, which writes to its argument; once it has written "r",
/// \a number is sent to it, and \a again if it isn't 0.
inline Ending endingOf(const std::function<int(int)>& program, int number, int again = 0)
{
    int pipe[2] = {};
    EXPECT_EQ(::pipe(pipe), 0);
    const pid_t child = ::fork();
    if (child == 0)
    {
        ::close(pipe[0]);
        ::alarm(30); // so that a test fails rather than hangs
        ::_exit(program(pipe[1]));
    }
    ::close(pipe[1]);
    Ending ending;
    char byte = 0;
    EXPECT_EQ(::read(pipe[0], &byte, 1), 1);
    const auto begin = std::chrono::steady_clock::now();
    ::kill(child, number);
    if (again != 0)
    {
        letPass(0.1);
        ::kill(child, again);
    }
    constexpr int kLook_ms = 5;
    for (auto look = std::chrono::steady_clock::now();;)
    {
        pollfd said{pipe[0], POLLIN, 0};
        const int ready = ::poll(&said, 1, kLook_ms);
        const auto now = std::chrono::steady_clock::now();
        ending.busy_s +=
            std::max(std::chrono::duration<double>(now - look).count() - 2e-3 * kLook_ms, 0.0);
        look = now;
        if (ready == 0) continue;
        if (::read(pipe[0], &byte, 1) != 1) break;
        ending.said += byte;
    }
    ::close(pipe[0]);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    ending.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (WIFSIGNALED(status)) ending.signal = WTERMSIG(status);
    if (WIFEXITED(status)) ending.code = WEXITSTATUS(status);
    return ending;
}
