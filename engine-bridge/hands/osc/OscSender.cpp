#include "engine-bridge/hands/osc/OscSender.h"

#include "haptics/base/InputError.h"

#include <array>
#include <cerrno>
#include <system_error>

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::bridge
{

OscSender::OscSender(const OscOptions& to)
{
    requireOsc();
    const SocketAddress address = SocketAddress::parse(to.address, to.port);
    _socket = ::socket(address.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (_socket < 0 || ::connect(_socket, address.get(), address.size()) != 0)
    {
        const std::string why = std::generic_category().message(errno);
        if (_socket >= 0) ::close(_socket);
        throw base::InputError(
            fmt::format("osc: {} port {} can't be sent to: {}", to.address, to.port, why));
    }
}

OscSender::OscSender(int socket) : _socket((requireOsc(), socket)) {}

OscSender::~OscSender()
{
    ::close(_socket);
}

bool OscSender::send(const std::vector<Hand>& hands, double time_s)
{
    return sendBytes(_writer.hands(hands, time_s));
}

bool OscSender::send(const Head& head)
{
    return sendBytes(_writer.head(head));
}

bool OscSender::say(const std::string& text)
{
    return sendBytes(_writer.text(text));
}

bool OscSender::sendBytes(std::size_t size)
{
    // If nobody listens yet, UDP reports an error of the last datagram at the next one.
    for (int i = 0; i < 2; ++i)
    {
        if (::send(_socket, _writer.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return true;
        if (errno != ECONNREFUSED && errno != EINTR) return false;
    }
    return false;
}

bool OscSender::listen()
{
    std::array<char, kMostOscBytes> bytes;
    for (;;)
    {
        const ssize_t size = ::recv(_socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
        // Nobody listens at the other end of UDP now, but may later.
        if (size < 0) return errno == EAGAIN || errno == EINTR || errno == ECONNREFUSED;
        if (size == 0) return false;
        try
        {
            const OscContent content = decodeOsc(bytes.data(), static_cast<std::size_t>(size));
            if (content.horizon_s >= 0.0) _horizon_s = content.horizon_s;
        }
        catch (const base::InputError&)
        {
            // The receiver belongs to this kit: other UDP input is ignored.
        }
    }
}

} // namespace midair::bridge
