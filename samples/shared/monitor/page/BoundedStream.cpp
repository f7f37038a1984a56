#include "samples/shared/monitor/page/BoundedStream.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <charconv>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>

namespace midair::samples
{

namespace
{

constexpr std::size_t kMostDrained = 65536;

/// Waits until bytes may be received (POLLIN) or sent (POLLOUT), or the other side has hung up.
/// Returns false after \a end_s.
bool waitFor(int socket, short events, double end_s)
{
    for (;;)
    {
        const double left_s = end_s - base::steadySeconds();
        if (left_s <= 0.0) return false;
        pollfd polled{socket, events, 0};
        if (::poll(&polled, 1, 1 + static_cast<int>(1e3 * left_s)) > 0) return true;
    }
}

/// Texts have no control characters but blanks and line ends; a greeting of TLS has.
bool isText(char c)
{
    const auto code = static_cast<unsigned char>(c);
    return (code >= 0x20 && code != 0x7F) || c == '\r' || c == '\n' || c == '\t';
}

} // namespace

BoundedStream::BoundedStream(int socket, const PageLimits& limits) :
    _socket(socket),
    _limits(limits),
    _headEnd_s(base::steadySeconds() + limits.head_s)
{
}

bool BoundedStream::fill(double end_s)
{
    if (!waitFor(_socket, POLLIN, end_s)) return false;
    const ssize_t got = ::recv(_socket, _buffer.data(), _buffer.size(), MSG_DONTWAIT);
    _got = static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    _at = 0;
    return got > 0;
}

/// The library asks for one byte at a time, and for none behind the empty line.
ssize_t BoundedStream::read(char* to, std::size_t)
{
    if (_headBytes++ == _limits.headBytes || (_at == _got && !fill(_headEnd_s))) return -1;
    *to = _buffer[_at++];
    return isText(*to) ? 1 : -1;
}

ssize_t BoundedStream::write(const char* from, std::size_t size)
{
    // The head of an answer comes as one; there may be one that says "100 Continue" before it.
    if (_status < 200 && size > 12) std::from_chars(from + 9, from + 12, _status);
    if (_writeEnd_s == 0.0) _writeEnd_s = base::steadySeconds() + _limits.write_s;
    for (std::size_t done = 0; done < size;)
    {
        if (!waitFor(_socket, POLLOUT, _writeEnd_s)) return -1;
        const ssize_t sent = ::send(_socket, from + done, size - done, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0) return -1;
        done += static_cast<std::size_t>(sent);
    }
    return static_cast<ssize_t>(size);
}

void BoundedStream::finish()
{
    // Closed at once, with bytes unread, it would take the answer back from the other side.
    ::shutdown(_socket, SHUT_WR);
    const double end_s = base::steadySeconds() + _limits.drain_s;
    for (std::size_t drained = 0; drained <= kMostDrained && fill(end_s);)
        drained += _got;
}

/// An IPv4 address that came as IPv6 is written as IPv4.
void BoundedStream::get_remote_ip_and_port(std::string& address, int& port) const
{
    sockaddr_storage peer{};
    socklen_t size = sizeof(peer);
    auto* const any = reinterpret_cast<sockaddr*>(&peer);
    std::array<char, NI_MAXHOST> text{};
    if (::getpeername(_socket, any, &size) == 0 &&
        ::getnameinfo(any, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0)
        address = text.data();
    const std::string mapped = "::ffff:";
    if (address.compare(0, mapped.size(), mapped) == 0) address.erase(0, mapped.size());
    port = 0;
}

} // namespace midair::samples
