#include "engine-bridge/hands/osc/SocketAddress.h"

#include "haptics/base/InputError.h"

#include <cstring>
#include <memory>

#include <netdb.h>
#include <netinet/in.h>

namespace midair::bridge
{

SocketAddress SocketAddress::parse(const std::string& address, int port)
{
    if (port < 0 || port > 65535)
        throw base::InputError("port " + std::to_string(port) + " should be 0 .. 65535");
    addrinfo wanted{};
    wanted.ai_family = AF_UNSPEC;
    wanted.ai_socktype = SOCK_DGRAM;
    wanted.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
    addrinfo* found = nullptr;
    const int failed =
        ::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &wanted, &found);
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, ::freeaddrinfo);
    if (failed != 0 || !found)
        throw base::InputError("address=" + address +
                               " should be a numeric address of this machine: 127.0.0.1, or "
                               "0.0.0.0 for all of them");
    SocketAddress result;
    result._size = found->ai_addrlen;
    std::memcpy(&result._address, found->ai_addr, found->ai_addrlen);
    return result;
}

SocketAddress SocketAddress::boundTo(int socket)
{
    SocketAddress result;
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&result._address), &result._size);
    return result;
}

int SocketAddress::port() const
{
    // Both families have the port at the same place.
    in_port_t port = 0;
    if (family() == AF_INET6)
        port = reinterpret_cast<const sockaddr_in6*>(&_address)->sin6_port;
    else
        port = reinterpret_cast<const sockaddr_in*>(&_address)->sin_port;
    return ntohs(port);
}

} // namespace midair::bridge
