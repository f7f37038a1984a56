#include "samples/monitor/server/Connections.h"

#include "samples/monitor/server/PlainAnswer.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

constexpr std::size_t kMostDrained = 65536;

/// An address as the socket calls want it.
struct RawAddress
{
    sockaddr_storage bytes{};
    socklen_t size = 0;
};

RawAddress rawOf(const MonitorAddress& address)
{
    RawAddress raw;
    if (address.isV6())
    {
        sockaddr_in6 v6{};
        v6.sin6_family = AF_INET6;
        v6.sin6_port = htons(static_cast<std::uint16_t>(address.port));
        ::inet_pton(AF_INET6, address.host.c_str(), &v6.sin6_addr);
        raw.size = sizeof(v6);
        std::memcpy(&raw.bytes, &v6, sizeof(v6));
        return raw;
    }
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(static_cast<std::uint16_t>(address.port));
    ::inet_pton(AF_INET, address.host.c_str(), &v4.sin_addr);
    raw.size = sizeof(v4);
    std::memcpy(&raw.bytes, &v4, sizeof(v4));
    return raw;
}

/// Texts have no control characters but blanks and line ends; a greeting of TLS has.
bool isText(const char* bytes, std::size_t count)
{
    return std::none_of(bytes,
                        bytes + count,
                        [](char c)
                        {
                            const auto code = static_cast<unsigned char>(c);
                            return (code < 0x20 && c != '\r' && c != '\n' && c != '\t') ||
                                   code == 0x7F;
                        });
}

bool isForLater(int error)
{
    return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

} // namespace

OwnedFile::~OwnedFile()
{
    if (_file >= 0) ::close(_file);
}

OwnedFile& OwnedFile::operator=(OwnedFile&& other) noexcept
{
    std::swap(_file, other._file);
    return *this;
}

OwnedFile listenOn(const MonitorAddress& address)
{
    const auto fail = [&]
    {
        throw std::runtime_error(
            fmt::format("can't listen on {}: {}", address.text(), std::strerror(errno)));
    };
    OwnedFile listener(::socket(
        address.isV6() ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (listener.get() < 0) fail();
    // A port whose last connections are only just closed is free; one that another program listens
    // on isn't, as it would be with SO_REUSEPORT.
    const int on = 1;
    ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    const RawAddress raw = rawOf(address);
    if (::bind(listener.get(), reinterpret_cast<const sockaddr*>(&raw.bytes), raw.size) != 0 ||
        ::listen(listener.get(), 64) != 0)
        fail();
    return listener;
}

int portOf(const OwnedFile& socket)
{
    RawAddress raw;
    raw.size = sizeof(raw.bytes);
    ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&raw.bytes), &raw.size);
    // Both families have the port at the same place.
    return ntohs(reinterpret_cast<const sockaddr_in*>(&raw.bytes)->sin_port);
}

Connection::Connection(OwnedFile socket, std::string peer, std::uint64_t number, double end_s) :
    _socket(std::move(socket)),
    _peer(std::move(peer)),
    _number(number),
    _end_s(end_s)
{
}

pollfd Connection::polled() const
{
    short events = 0;
    if (_stage == READING || _stage == DRAINING) events = POLLIN;
    if (_stage == WRITING) events = POLLOUT;
    return {_socket.get(), events, 0};
}

void Connection::move(short events, double now_s, const ConnectionLimits& limits)
{
    if ((events & (POLLIN | POLLOUT | POLLHUP | POLLERR | POLLNVAL)) == 0) return;
    switch (_stage)
    {
    case READING:
        return readSome(now_s, limits);
    case WRITING:
        return writeSome(now_s, limits);
    case DRAINING:
        return drainSome();
    default: // nobody waits for the answer any more
        _stage = CLOSED;
    }
}

void Connection::readSome(double now_s, const ConnectionLimits& limits)
{
    std::array<char, 4096> buffer{};
    const ssize_t got = ::recv(_socket.get(), buffer.data(), buffer.size(), 0);
    if (got < 0 && isForLater(errno)) return;
    if (got <= 0)
    {
        _stage = CLOSED;
        return;
    }
    const auto count = static_cast<std::size_t>(got);
    const std::size_t before = _head.size();
    _head.append(buffer.data(), count);
    // The end may have begun in what was there before.
    const std::size_t end = _head.find("\r\n\r\n", before < 3 ? 0 : before - 3);
    const std::size_t size = end == std::string::npos ? _head.size() : end + 4;
    if (size > limits.headBytes) return write(plainAnswer(431, "that is too long"), now_s, limits);
    if (!isText(_head.data() + before, size - std::min(size, before)))
        return write(plainAnswer(400, "that is no HTTP request"), now_s, limits);
    if (end == std::string::npos) return;
    _head.resize(size);
    _stage = WORKING;
    _end_s = now_s + limits.answer_s;
}

void Connection::write(std::string answer, double now_s, const ConnectionLimits& limits)
{
    _answer = std::move(answer);
    _stage = WRITING;
    _end_s = now_s + limits.write_s;
    writeSome(now_s, limits);
}

void Connection::writeSome(double now_s, const ConnectionLimits& limits)
{
    const ssize_t sent =
        ::send(_socket.get(), _answer.data() + _written, _answer.size() - _written, MSG_NOSIGNAL);
    if (sent < 0 && isForLater(errno)) return;
    if (sent < 0)
    {
        _stage = CLOSED;
        return;
    }
    _written += static_cast<std::size_t>(sent);
    if (_written < _answer.size()) return;
    // Closed at once, with bytes unread, it would take the answer back from the other side.
    ::shutdown(_socket.get(), SHUT_WR);
    _stage = DRAINING;
    _end_s = now_s + limits.drain_s;
}

void Connection::drainSome()
{
    std::array<char, 4096> buffer{};
    const ssize_t got = ::recv(_socket.get(), buffer.data(), buffer.size(), 0);
    if (got < 0 && isForLater(errno)) return;
    if (got > 0) _drained += static_cast<std::size_t>(got);
    if (got <= 0 || _drained > kMostDrained) _stage = CLOSED;
}

void Connection::expire(double now_s, const ConnectionLimits& limits)
{
    if (_stage == READING)
        return write(plainAnswer(408, "the request didn't come in time"), now_s, limits);
    if (_stage == WORKING)
        return write(plainAnswer(504,
                                 "the program doesn't answer: whatever was asked for may not have "
                                 "been done"),
                     now_s,
                     limits);
    _stage = CLOSED;
}

} // namespace midair::samples
