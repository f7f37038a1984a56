#include "samples/tools/tune/ReadingSource.h"

#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

constexpr int kTick_ms = 5;
constexpr std::size_t kMostBuffered = std::size_t(1) << 20;
const std::string kExec = "exec:";

[[noreturn]] void fail(const std::string& what)
{
    throw base::InputError(what + ": " + std::generic_category().message(errno));
}

} // namespace

ReadingSource::ReadingSource(const std::string& name)
{
    if (name == "-")
    {
        _in = STDIN_FILENO;
        _requests = STDOUT_FILENO;
    }
    else if (name.rfind(kExec, 0) == 0)
        run(name.substr(kExec.size()));
    else
        open(name);
}

void ReadingSource::open(const std::string& path)
{
    struct stat about = {};
    if (::stat(path.c_str(), &about) != 0) fail("readings \"" + path + "\" can't be read");
    if (S_ISDIR(about.st_mode))
        throw base::InputError("readings \"" + path +
                               "\" are a folder; they should be a file or a named pipe, - or "
                               "exec:COMMAND");
    // A pipe that is open for writing here, too, doesn't end when an instrument closes it.
    const bool isPipe = S_ISFIFO(about.st_mode);
    _in = ::open(path.c_str(), (isPipe ? O_RDWR : O_RDONLY) | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (_in < 0) fail("readings \"" + path + "\" can't be read");
    _grows = S_ISREG(about.st_mode);
}

void ReadingSource::run(const std::string& command)
{
    if (command.empty()) throw base::InputError("readings \"exec:\" lack a command: exec:COMMAND");
    std::array<int, 2> to{}, from{};
    if (::pipe2(to.data(), O_CLOEXEC) != 0 || ::pipe2(from.data(), O_CLOEXEC) != 0)
        fail("no pipe to \"" + command + "\"");
    _child = ::fork();
    if (_child < 0) fail("\"" + command + "\" can't be run");
    if (_child == 0)
    {
        ::setpgid(0, 0); // Ctrl-C is the caller's, who ends the command when the array is silent
        ::dup2(to[0], STDIN_FILENO);
        ::dup2(from[1], STDOUT_FILENO);
        std::signal(SIGPIPE, SIG_DFL);
        ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
        ::_exit(127);
    }
    ::close(to[0]);
    ::close(from[1]);
    _requests = to[1];
    _in = from[0];
}

ReadingSource::~ReadingSource()
{
    if (_child > 0)
    {
        closeRequests();
        ::close(_in);
        ::kill(-_child, SIGTERM);
        ::kill(_child, SIGTERM);
        while (::waitpid(_child, nullptr, 0) < 0 && errno == EINTR)
        {
        }
    }
    else if (_in > STDERR_FILENO)
        ::close(_in);
}

void ReadingSource::request(const std::string& line)
{
    const std::string text = line + "\n";
    for (std::size_t done = 0; _requests >= 0 && done < text.size();)
    {
        const ssize_t wrote = ::write(_requests, text.data() + done, text.size() - done);
        if (wrote > 0)
            done += static_cast<std::size_t>(wrote);
        else if (errno != EINTR) // nobody reads them: what is written may come nevertheless
            closeRequests();
    }
}

void ReadingSource::closeRequests()
{
    if (_requests > STDERR_FILENO) ::close(_requests);
    _requests = -1;
}

bool ReadingSource::take(std::string& line)
{
    const std::size_t end = _buffer.find('\n');
    if (end == std::string::npos) return false;
    line = _buffer.substr(0, end);
    _buffer.erase(0, end + 1);
    return true;
}

bool ReadingSource::fill(int wait_ms)
{
    pollfd polled{_in, POLLIN, 0};
    const int ready = ::poll(&polled, 1, wait_ms);
    if (ready <= 0) return true;
    std::array<char, 4096> bytes{};
    const ssize_t got = ::read(_in, bytes.data(), bytes.size());
    if (got > 0)
        _buffer.append(bytes.data(), static_cast<std::size_t>(got));
    else if (got == 0 && _grows)
        ::usleep(1000 * static_cast<useconds_t>(wait_ms));
    else if (got == 0 || (errno != EINTR && errno != EAGAIN))
        return false;
    return _buffer.size() < kMostBuffered;
}

LineState
ReadingSource::next(std::string& line, double limit_s, const std::function<bool()>& goesOn)
{
    const double end_s = base::steadySeconds() + limit_s;
    for (;;)
    {
        if (take(line)) return LineState::LINE;
        if (_ended) return LineState::END;
        if (!goesOn()) return LineState::STOPPED;
        if (base::steadySeconds() > end_s) return LineState::TIME_OUT;
        _ended = !fill(kTick_ms);
    }
}

void ReadingSource::drop()
{
    for (std::size_t before = 1; !_ended && before != _buffer.size();)
    {
        before = _buffer.size();
        _ended = !fill(0);
        // What is read while the buffer empties would never end with a fast instrument.
        if (_buffer.size() > kMostBuffered / 2) break;
    }
    const std::size_t last = _buffer.rfind('\n');
    if (last != std::string::npos) _buffer.erase(0, last + 1);
}

} // namespace midair::samples
