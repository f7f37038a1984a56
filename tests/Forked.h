#pragma once

#include "tests/Eventually.h"

#include <csignal>
#include <cstdlib>
#include <functional>

#include <sys/wait.h>
#include <unistd.h>

/// Runs \a work in the child of a fork, which ends by exit() with what it returns. Returns that; -1
/// if the child was still there after all patience, or ended otherwise.
inline int inChild(const std::function<int()>& work)
{
    const pid_t child = ::fork();
    if (child == 0) std::exit(work());
    if (child < 0) return -1;
    int status = 0;
    if (!eventually([&] { return ::waitpid(child, &status, WNOHANG) == child; }, 30.0))
    {
        ::kill(child, SIGKILL);
        ::waitpid(child, &status, 0);
        return -1;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}
