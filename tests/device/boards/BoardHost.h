#pragma once

#include "tests/Emulator.h"
#include "tests/device/Guards.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

/// This program once more under a name of its own, as one that opens a board, plays a field
/// (randomField(.., 1)) on it, or that and silence in turn, 200 times a second, and never closes
/// it.
class BoardHost
{
public:
    BoardHost(const std::string& uri, int transducers, bool isModulated = false)
    {
        static int count = 0;
        name = "mh" + std::to_string(::getpid()) + "x" + std::to_string(count++);
        _link = std::filesystem::temp_directory_path() / name;
        std::filesystem::remove(_link);
        std::string self = std::filesystem::read_symlink("/proc/self/exe");
        const char* emulator = emulatorOfTests();
        std::filesystem::create_symlink(emulator != nullptr ? emulator : self.c_str(), _link);
        for (const char* shard : {"GTEST_TOTAL_SHARDS", "GTEST_SHARD_INDEX"})
            ::unsetenv(shard); // or its only test may be another shard's
        ::setenv("MIDAIR_TEST_HOST", uri.c_str(), 1);
        ::setenv("MIDAIR_TEST_HOST_TRANSDUCERS", std::to_string(transducers).c_str(), 1);
        ::setenv("MIDAIR_TEST_HOST_MODULATED", isModulated ? "yes" : "no", 1);
        std::string program = _link;
        std::string filter = "--gtest_filter=BoardHost.DISABLED_plays_until_it_is_ended";
        std::string disabled = "--gtest_also_run_disabled_tests";
        std::string brief = "--gtest_brief=1";
        std::vector<char*> arguments = {program.data()};
        if (emulator != nullptr) arguments.push_back(self.data());
        arguments.insert(arguments.end(), {filter.data(), disabled.data(), brief.data(), nullptr});
        if (::posix_spawn(
                &_process, program.c_str(), nullptr, nullptr, arguments.data(), environ) != 0)
            throw std::runtime_error("can't start this program again");
    }
    ~BoardHost()
    {
        send(SIGKILL);
        wait();
        std::filesystem::remove(_link);
    }

    BoardHost(const BoardHost&) = delete;
    BoardHost& operator=(const BoardHost&) = delete;

    /// Whether it has the port's guard, without which nobody silences the board after it.
    bool guarded() const { return !guardsOf(_process).empty(); }
    void send(int signal)
    {
        if (_process > 0) ::kill(_process, signal);
    }
    void wait()
    {
        if (_process > 0) ::waitpid(_process, nullptr, 0);
        _process = 0;
    }

    std::string name; ///< of the process

private:
    std::filesystem::path _link;
    pid_t _process = 0;
};
