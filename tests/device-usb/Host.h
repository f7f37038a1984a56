#pragma once

#include <csignal>
#include <stdexcept>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

/// This program once more, as one that opens what the test emulates, plays on it and never closes
/// it.
class Host
{
public:
    /// \a argument: "--host" for the array, which it sends fields for ever; "--fifo-host" for the
    /// board behind an FT232H, which it sends one field and then stops itself.
    explicit Host(const char* argument)
    {
        char program[] = "/proc/self/exe";
        char* const arguments[] = {program, const_cast<char*>(argument), nullptr};
        if (::posix_spawn(&_process, program, nullptr, nullptr, arguments, environ) != 0)
            throw std::runtime_error("can't start this program again");
    }
    ~Host() { kill(); }

    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    /// Until it has stopped itself; false when it has ended instead.
    bool waitUntilStopped()
    {
        int status = 0;
        const bool stopped =
            ::waitpid(_process, &status, WUNTRACED) == _process && WIFSTOPPED(status);
        if (!stopped) _process = 0;
        return stopped;
    }

    /// By SIGKILL; it is dead when this returns.
    void kill()
    {
        if (_process == 0) return;
        ::kill(_process, SIGKILL);
        ::waitpid(_process, nullptr, 0);
        _process = 0;
    }

private:
    pid_t _process = 0;
};
