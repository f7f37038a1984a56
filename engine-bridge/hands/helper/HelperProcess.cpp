#include "engine-bridge/hands/helper/HelperProcess.h"

#include "haptics/base/InputError.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

namespace fs = std::filesystem;

/// Isolates the helper from this process: only these files, no blocked signals, and no ignored
/// ones.
class SpawnSettings
{
public:
    explicit SpawnSettings(int socket)
    {
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&files, socket, HelperProcess::kSocket);
        posix_spawn_file_actions_addclosefrom_np(&files, HelperProcess::kSocket + 1);
        posix_spawnattr_init(&attributes);
        sigset_t none;
        sigemptyset(&none);
        posix_spawnattr_setsigmask(&attributes, &none);
        sigset_t all;
        sigfillset(&all);
        posix_spawnattr_setsigdefault(&attributes, &all);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    }
    ~SpawnSettings()
    {
        posix_spawnattr_destroy(&attributes);
        posix_spawn_file_actions_destroy(&files);
    }
    SpawnSettings(const SpawnSettings&) = delete;
    SpawnSettings& operator=(const SpawnSettings&) = delete;

    posix_spawn_file_actions_t files{};
    posix_spawnattr_t attributes{};
};

} // namespace

HelperProcess::HelperProcess(const std::vector<std::string>& command)
{
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
        throw base::InputError("there is no socket for the helper: " +
                               std::generic_category().message(errno));
    // dup2() onto the same number would leave close-on-exec set.
    if (ends[1] == kSocket)
    {
        const int other = ::fcntl(ends[1], F_DUPFD_CLOEXEC, kSocket + 1);
        ::close(ends[1]);
        ends[1] = other;
    }
    std::vector<std::string> words = command;
    std::vector<char*> arguments;
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const SpawnSettings settings(ends[1]);
    const int failed = ::posix_spawn(&_process,
                                     command.at(0).c_str(),
                                     &settings.files,
                                     &settings.attributes,
                                     arguments.data(),
                                     environ);
    ::close(ends[1]);
    _socket = ends[0];
    if (failed == 0) return;
    ::close(_socket);
    throw base::InputError("the helper \"" + command.at(0) +
                           "\" can't be started: " + std::generic_category().message(failed));
}

HelperProcess::~HelperProcess()
{
    end();
}

// Returns true if it has ended.
bool HelperProcess::reap(int flags, std::string& how)
{
    int status = 0;
    const pid_t ended = ::waitpid(_process, &status, flags);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
    how = ended < 0             ? "was reaped by the program itself"
          : WIFSIGNALED(status) ? fmt::format("was killed by signal {}", WTERMSIG(status))
                                : fmt::format("ended with {}", WEXITSTATUS(status));
    _process = -1;
    return true;
}

std::string HelperProcess::end()
{
    if (_socket >= 0) ::close(_socket);
    _socket = -1;
    std::string how = "has ended";
    const double until_s = base::steadySeconds() + kPatience_s;
    while (_process > 0 && base::steadySeconds() < until_s)
        if (!reap(WNOHANG, how)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (_process > 0) ::kill(_process, SIGKILL);
    while (_process > 0)
        reap(0, how);
    return how;
}

std::string programBeside(const std::string& name)
{
    const fs::path own = base::ownFolder();
    if (own.empty()) return {};
    std::error_code ignored;
    // Beside a program; for a library, as installed, as built, and as in the tests.
    for (const char* way : {".", MIDAIR_PROGRAMS_FROM_LIBRARY, "../bin", "../../bin"})
    {
        const fs::path file = (own / way / name).lexically_normal();
        if (fs::is_regular_file(file, ignored) && ::access(file.c_str(), X_OK) == 0)
            return file.string();
    }
    return {};
}

} // namespace midair::bridge
