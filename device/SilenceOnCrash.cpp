#include "device/SilenceOnCrash.h"

#include "device/DeviceLog.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <system_error>

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

namespace midair::device
{

namespace
{

constexpr int kWriteTimeout_ms = 500;
constexpr int kPatience_ms = 500;
constexpr int kStart_ms = 5000; ///< for the child, on a busy computer
constexpr int kTries = 4;       ///< timeouts in a row after which the write is given up
/// Maximum bytes per usbfs transfer, also in old kernels.
constexpr std::size_t kMostBulkBytes = 16384;
constexpr char kName[] = "midair-guard"; ///< 15 bytes at most
constexpr char kReady = 'r';
constexpr char kBeat = 'b';
constexpr char kHeldBeat = 'h';
constexpr char kFarewell = 'x';

// All of this namespace except hears() runs in the child: it may only make calls that are safe
// after a fork of a multithreaded program.

bool gone(int descriptor)
{
    pollfd port{descriptor, 0, 0};
    return ::poll(&port, 1, 0) > 0 && (port.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0;
}

bool writeBytes(int descriptor, const std::uint8_t* bytes, std::size_t size)
{
    int tries = 0;
    while (size > 0 && tries < kTries)
    {
        const ssize_t written = ::write(descriptor, bytes, size);
        if (written < 0 && errno == EAGAIN)
        {
            pollfd wait{descriptor, POLLOUT, 0};
            if (::poll(&wait, 1, kWriteTimeout_ms) == 0) ++tries;
            if ((wait.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) return false;
        }
        else if (written < 0 && errno != EINTR)
            return false;
        else if (written > 0)
        {
            tries = 0;
            bytes += written;
            size -= static_cast<std::size_t>(written);
        }
    }
    return size == 0;
}

// Transfers that the dead process had in flight go out first: they belong to the descriptor and
// wait at the same endpoint.
bool writeBulk(const SilenceOnCrash::Way& way, const std::uint8_t* bytes, std::size_t size)
{
    while (size > 0)
    {
        usbdevfs_bulktransfer transfer{};
        transfer.ep = way.endpoint;
        transfer.len = static_cast<unsigned>(std::min(size, kMostBulkBytes));
        transfer.timeout = kWriteTimeout_ms;
        transfer.data = const_cast<std::uint8_t*>(bytes); // only read
        const int written = ::ioctl(way.descriptor, USBDEVFS_BULK, &transfer);
        if (written < 0 && errno != EINTR) return false;
        if (written == 0) return false;
        if (written > 0)
        {
            bytes += written;
            size -= static_cast<std::size_t>(written);
        }
    }
    return true;
}

// Sets the short name and the command line, so that a killall of the program spares the guard. The
// command line is in memory, at fields 48 and 49 of /proc/self/stat.
void takeName()
{
    ::prctl(PR_SET_NAME, kName);
    char text[1024];
    const int file = ::open("/proc/self/stat", O_RDONLY | O_CLOEXEC);
    const ssize_t size = file < 0 ? 0 : ::read(file, text, sizeof text - 1);
    if (file >= 0) ::close(file);
    if (size <= 0) return;
    text[size] = 0;
    const char* at = std::strrchr(text, ')');
    for (int field = 2; at != nullptr && field < 48; ++field)
        at = std::strchr(at + 1, ' ');
    if (at == nullptr) return;
    std::uintptr_t begin = 0;
    std::uintptr_t end = 0;
    const char* next = std::from_chars(at + 1, text + size, begin).ptr;
    if (next < text + size) std::from_chars(next + 1, text + size, end);
    if (begin == 0 || end <= begin) return;
    auto* line =
        reinterpret_cast<char*>(begin); // NOLINT(performance-no-int-to-ptr): the kernel's number
    std::memset(line, 0, end - begin);
    std::memcpy(line, kName, std::min<std::size_t>(sizeof kName, end - begin) - 1);
}

/// The child's copy of its data.
struct Charge
{
    int alive;
    SilenceOnCrash::Way way;
    const std::uint8_t* bytes;
    std::size_t size;
    double notBefore_s;
    double held_s;

    static double now_s() // steadySeconds()
    {
        timespec now{};
        ::clock_gettime(CLOCK_MONOTONIC, &now);
        return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
    }
    double early_s() const { return notBefore_s - now_s(); }
    bool write() const
    {
        return way.endpoint == 0 ? writeBytes(way.descriptor, bytes, size)
                                 : writeBulk(way, bytes, size);
    }
    // Program output stuck in the port would be sent before the silence. A second silence doesn't
    // drop the first, which a slow line may still be sending.
    void dropOutput() const
    {
        if (way.endpoint == 0) ::tcflush(way.descriptor, TCOFLUSH);
    }
    bool writeInTime() const
    {
        double rest_s = early_s();
        while (rest_s > 0 && !gone(way.descriptor))
        {
            ::poll(nullptr, 0, std::min(100, static_cast<int>(rest_s * 1000) + 1));
            rest_s = early_s();
        }
        dropOutput();
        return write();
    }
};

[[noreturn]] void guard(Charge charge)
{
    const std::uint64_t all = ~std::uint64_t(0); // libc's mask leaves out two signals, which would
                                                 // end it
    ::syscall(SYS_rt_sigprocmask, SIG_SETMASK, &all, nullptr, sizeof all);
    ::setsid(); // so that a Ctrl-C for the program doesn't reach the guard
    takeName();
    // Closes all other descriptors: other ports, other devices' claims, the sockets of other
    // guards.
    const auto low = static_cast<unsigned>(std::min(charge.alive, charge.way.descriptor));
    const auto high = static_cast<unsigned>(std::max(charge.alive, charge.way.descriptor));
    if (low > 0) ::close_range(0, low - 1, 0);
    if (high > low + 1) ::close_range(low + 1, high - 1, 0);
    ::close_range(high + 1, ~0U, 0);
    ::send(charge.alive, &kReady, 1, MSG_NOSIGNAL);
    bool beating = false;
    bool silenced = false; // since the last beat
    while (true)
    {
        pollfd program{charge.alive, POLLIN, 0};
        const int ready = ::poll(&program, 1, beating ? kPatience_ms : -1);
        if (ready == 0) // the program is stopped or hangs: writes every time
        {
            if (charge.early_s() > 0) continue;
            if (!silenced) charge.dropOutput();
            charge.write();
            silenced = true;
            continue;
        }
        char words[64];
        const ssize_t count = ::recv(charge.alive, words, sizeof words, 0);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) ::_exit(charge.writeInTime() ? 0 : 1); // closed: the program has died
        if (words[count - 1] == kFarewell) ::_exit(0);
        beating = true;
        silenced = false;
        if (words[count - 1] == kHeldBeat) charge.notBefore_s = Charge::now_s() + charge.held_s;
    }
}

/// Waits for \a word, which the child sends when it needs nothing more; false: it didn't arrive.
bool hears(int socket, char word)
{
    pollfd child{socket, POLLIN, 0};
    int ready = 0;
    do
        ready = ::poll(&child, 1, kStart_ms);
    while (ready < 0 && errno == EINTR);
    char heard = 0;
    return ready > 0 && ::recv(socket, &heard, 1, MSG_DONTWAIT) == 1 && heard == word;
}

} // namespace

SilenceOnCrash::SilenceOnCrash(const Way& way,
                               const std::vector<std::uint8_t>& bytes,
                               double notBefore_s,
                               double held_s)
{
    int ends[2];
    const bool paired = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0;
    // The program's own handlers must not run in the child, and only SIGKILL and SIGSTOP may end or
    // stop it.
    sigset_t all;
    sigset_t before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    if (paired) _guard = ::fork();
    if (_guard == 0)
    {
        ::close(ends[1]);
        guard({ends[0], way, bytes.data(), bytes.size(), notBefore_s, held_s});
    }
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    if (_guard < 0)
        deviceLog().warn("the board is not silenced if this program crashes: {}",
                         std::generic_category().message(errno));
    if (!paired) return;
    ::close(ends[0]);
    _alive = ends[1];
    if (_guard > 0 && !hears(_alive, kReady))
        deviceLog().warn("the guard process, which silences the board if this program crashes, "
                         "hasn't started within {} s",
                         kStart_ms / 1000);
}

SilenceOnCrash::~SilenceOnCrash()
{
    if (_alive >= 0)
    {
        while (::send(_alive, &kFarewell, 1, MSG_NOSIGNAL) < 0 && errno == EINTR)
        {
        }
        ::close(_alive);
    }
    await();
}

void SilenceOnCrash::beat(bool held)
{
    if (_alive >= 0) ::send(_alive, held ? &kHeldBeat : &kBeat, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
}

bool SilenceOnCrash::execute()
{
    if (_alive >= 0)
    {
        // Not only close(): another child of the program may hold it too.
        ::shutdown(_alive, SHUT_RDWR);
        ::close(_alive);
    }
    _alive = -1;
    return await();
}

bool SilenceOnCrash::await()
{
    if (_guard <= 0) return false;
    int status = 0;
    pid_t ended = 0;
    do
        ended = ::waitpid(_guard, &status, 0);
    while (ended < 0 && errno == EINTR);
    const bool wrote = ended == _guard && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    _guard = -1;
    return wrote;
}

} // namespace midair::device
