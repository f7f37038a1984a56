#include "device/LastWill.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>

#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace midair::device
{

namespace
{

constexpr int kWriteTimeout_ms = 500;
constexpr std::size_t kMostBulkBytes =
    16384; ///< that usbfs takes in one piece, also in old kernels

// All below runs in the child: only calls that are safe after a fork of a program with threads.

void writeBytes(int descriptor, const std::uint8_t* bytes, std::size_t size)
{
    while (size > 0)
    {
        const ssize_t written = ::write(descriptor, bytes, size);
        if (written < 0 && errno == EAGAIN)
        {
            pollfd wait{descriptor, POLLOUT, 0};
            ::poll(&wait, 1, kWriteTimeout_ms);
        }
        else if (written < 0 && errno != EINTR)
            break;
        else if (written > 0)
        {
            bytes += written;
            size -= static_cast<std::size_t>(written);
        }
    }
}

// What the dead process had in flight goes out first, since its transfers belong to the descriptor and wait at the same endpoint.
void writeBulk(const LastWill::Way& way, const std::uint8_t* bytes, std::size_t size)
{
    while (size > 0)
    {
        usbdevfs_bulktransfer transfer{};
        transfer.ep = way.endpoint;
        transfer.len = static_cast<unsigned>(std::min(size, kMostBulkBytes));
        transfer.timeout = kWriteTimeout_ms;
        transfer.data = const_cast<std::uint8_t*>(bytes); // only read
        const int written = ::ioctl(way.descriptor, USBDEVFS_BULK, &transfer);
        if (written < 0 && errno != EINTR) break;
        if (written == 0) break;
        if (written > 0)
        {
            bytes += written;
            size -= static_cast<std::size_t>(written);
        }
    }
}

[[noreturn]] void
guard(int alive, const LastWill::Way& way, const std::uint8_t* bytes, std::size_t size)
{
    ::setsid(); // a Ctrl-C for the program isn't for its guard
    ::signal(SIGTERM, SIG_IGN);
    ::signal(SIGHUP, SIG_IGN);
    // The rest isn't ours to hold: other ports, other devices' claims, the sockets of other guards.
    const auto low = static_cast<unsigned>(std::min(alive, way.descriptor));
    const auto high = static_cast<unsigned>(std::max(alive, way.descriptor));
    if (low > 0) ::close_range(0, low - 1, 0);
    if (high > low + 1) ::close_range(low + 1, high - 1, 0);
    ::close_range(high + 1, ~0U, 0);
    char farewell = 0;
    ssize_t count = 0;
    do
        count = ::read(alive, &farewell, 1);
    while (count < 0 && errno == EINTR);
    if (count == 0) // no farewell: the program has died
    {
        if (way.endpoint == 0)
            writeBytes(way.descriptor, bytes, size);
        else
            writeBulk(way, bytes, size);
    }
    ::_exit(0);
}

} // namespace

LastWill::LastWill(const Way& way, const std::vector<std::uint8_t>& bytes)
{
    int ends[2];
    const bool paired = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0;
    if (paired) _guard = ::fork();
    if (_guard < 0)
        spdlog::warn("nobody silences the board if this program crashes: {}",
                     std::generic_category().message(errno));
    if (!paired) return;
    if (_guard == 0)
    {
        ::close(ends[1]);
        guard(ends[0], way, bytes.data(), bytes.size());
    }
    ::close(ends[0]);
    _alive = ends[1];
}

LastWill::~LastWill()
{
    if (_alive >= 0)
    {
        const char farewell = 'x';
        while (::send(_alive, &farewell, 1, MSG_NOSIGNAL) < 0 && errno == EINTR)
        {
        }
        ::close(_alive);
    }
    if (_guard > 0)
        while (::waitpid(_guard, nullptr, 0) < 0 && errno == EINTR)
        {
        }
}

} // namespace midair::device
