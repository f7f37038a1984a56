#include "tests/device/boards/BoardEmulator.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

using midair::base::steadySeconds;

namespace
{

constexpr int kQuiet = 30; ///< reads of nothing, a millisecond apart, until nothing is on its way
constexpr std::size_t kBuffer = 128; ///< bytes that the USB chip of a Mega holds

std::string newFolder()
{
    std::string pattern = std::filesystem::temp_directory_path() / "midair-board-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    return pattern;
}

} // namespace

BoardEmulator::BoardEmulator(const std::string& board, int transducers, const Options& options) :
    _options(options),
    _swap(board == "ultraino" ? 0x00 : 253),
    _folder(newFolder()),
    _name(_folder + "/tty"),
    _board(midair::device::makeVirtualBoard(board, transducers))
{
    open();
}

BoardEmulator::BoardEmulator(const std::string& board, int transducers) :
    BoardEmulator(board, transducers, Options())
{
}

BoardEmulator::~BoardEmulator()
{
    unplug();
    std::filesystem::remove_all(_folder);
}

void BoardEmulator::open()
{
    _master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    char path[128] = {};
    if (_master < 0 || ::grantpt(_master) != 0 || ::unlockpt(_master) != 0 ||
        ::ptsname_r(_master, path, sizeof path) != 0)
        throw std::runtime_error("no pseudo-terminal");
    ::close(
        ::open(path, O_RDWR | O_NOCTTY | O_CLOEXEC)); // from here on it knows whether it is open
    std::filesystem::remove(_name);
    std::filesystem::create_symlink(path, _name);
    _opened = _dtr = false;
}

void BoardEmulator::start()
{
    _stop = false;
    _consumed_s = midair::base::steadySeconds();
    _thread = std::thread([this] { run(); });
}

void BoardEmulator::unplug()
{
    _stop = true;
    if (_thread.joinable()) _thread.join();
    if (_master >= 0) ::close(std::exchange(_master, -1));
    _buffer.clear();
}

void BoardEmulator::plug()
{
    open();
    start();
}

void BoardEmulator::run()
{
    while (!_stop)
    {
        watchLine();
        bool isQuiet = false;
        {
            std::lock_guard<std::mutex> lock(_mutex);
            isQuiet = !pump() && _buffer.empty();
            _emptyReads = isQuiet ? _emptyReads + 1 : 0;
        }
        ::poll(nullptr, 0, 1);
    }
}

// Takes what has come over the line by now, also for a thread that asks while ours waits for a
// processor. Returns true if there was something.
bool BoardEmulator::pump()
{
    std::uint8_t bytes[kBuffer];
    for (bool any = false;; any = true)
    {
        const double now_s = midair::base::steadySeconds();
        consume(now_s);
        const std::size_t space = kBuffer - _buffer.size();
        const ssize_t count = space > 0 && _master >= 0 ? ::read(_master, bytes, space) : 0;
        if (count <= 0)
        {
            if (space > 0) _idle_s = now_s;
            return any;
        }
        _buffer.insert(_buffer.end(), bytes, bytes + count);
    }
}

void BoardEmulator::watchLine()
{
    pollfd line{_master, 0, 0};
    ::poll(&line, 1, 0);
    const bool opened = (line.revents & POLLHUP) == 0;
    std::lock_guard<std::mutex> lock(_mutex);
    termios settings{};
    if (_opened && !opened && ::tcgetattr(_master, &settings) == 0)
        _dtr = (settings.c_cflag & HUPCL) == 0;
    if (!_opened && opened && !_dtr)
    {
        _dtr = true;
        if (_options.mega)
        {
            ++_resets;
            startUp(midair::base::steadySeconds());
        }
    }
    _opened = opened;
}

void BoardEmulator::startUp(double now_s)
{
    _booting = _options.mega;
    _held = false;
    _sketchAt_s = now_s + _options.boot_s;
    if (!_booting) _board->powerUp();
}

void BoardEmulator::consume(double now_s)
{
    const double byte_s = 10.0 / _options.baud;
    while (!_buffer.empty() && _consumed_s + byte_s <= now_s)
    {
        _consumed_s += byte_s;
        take(_buffer.front(), now_s);
        _buffer.pop_front();
    }
    // A line loses no time where this thread looks late: what comes next may be there already.
    if (_buffer.empty()) _consumed_s = std::max(_consumed_s, _idle_s);
    if (_booting && now_s >= _sketchAt_s)
    {
        _booting = false;
        _board->powerUp();
    }
}

void BoardEmulator::take(std::uint8_t byte, double now_s)
{
    ++_received;
    if (_damage > 0 && --_damage == 0) byte = static_cast<std::uint8_t>(~byte);
    if (_booting)
    {
        ++_eaten;
        _held = true;
        _sketchAt_s = now_s + _options.held_s;
    }
    else
        _board->receive(&byte, 1);
    const auto answer = _board->takeAnswer();
    if (!answer.empty() && _master >= 0 && _opened && _options.answers &&
        ::write(_master, answer.data(), answer.size()) < 0)
    {
        // a computer that doesn't read loses it
    }
}

void BoardEmulator::powerCycle()
{
    std::lock_guard<std::mutex> lock(_mutex);
    startUp(midair::base::steadySeconds());
}

void BoardEmulator::inject(std::uint8_t byte)
{
    std::lock_guard<std::mutex> lock(_mutex);
    take(byte, midair::base::steadySeconds());
}

void BoardEmulator::damage(std::size_t nth)
{
    std::lock_guard<std::mutex> lock(_mutex);
    _damage = nth;
}

std::vector<std::complex<float>> BoardEmulator::playing()
{
    std::lock_guard<std::mutex> lock(_mutex);
    auto q = _board->playing();
    if (_booting) std::fill(q.begin(), q.end(), std::complex<float>(0));
    return q;
}

bool BoardEmulator::silentLocked() const
{
    const auto q = _board->playing();
    return _booting || std::all_of(q.begin(),
                                   q.end(),
                                   [](std::complex<float> one) { return std::abs(one) == 0; });
}

bool BoardEmulator::silent()
{
    std::lock_guard<std::mutex> lock(_mutex);
    pump();
    return silentLocked();
}

bool BoardEmulator::silentInBothBuffers()
{
    std::lock_guard<std::mutex> lock(_mutex);
    if (_emptyReads < kQuiet || _booting || !silentLocked()) return false;
    _board->receive(&_swap, 1);
    const bool silent = silentLocked();
    _board->receive(&_swap, 1);
    return silent;
}

bool BoardEmulator::isOpened()
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _opened;
}

int BoardEmulator::resets()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _resets;
}

bool BoardEmulator::starting()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _booting;
}

std::uint64_t BoardEmulator::swaps()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _board->swaps();
}

std::uint64_t BoardEmulator::received()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _received;
}

std::uint64_t BoardEmulator::eaten()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _eaten;
}
