#pragma once

#include <string>

#include <sys/socket.h>

namespace midair::bridge
{

/// An address of the internet and a port.
class SocketAddress
{
public:
    /// \a address: numeric, IPv4 or IPv6, no name, for which the network would be asked. \a port: 0
    /// .. 65535. Throws base::InputError.
    static SocketAddress parse(const std::string& address, int port);
    /// What \a socket is bound to.
    static SocketAddress boundTo(int socket);

    int family() const { return _address.ss_family; }
    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&_address); }
    socklen_t size() const { return _size; }
    int port() const;

private:
    sockaddr_storage _address{};
    socklen_t _size = sizeof(sockaddr_storage);
};

} // namespace midair::bridge
