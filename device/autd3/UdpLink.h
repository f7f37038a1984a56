#pragma once

#include "device/autd3/DatagramLink.h"

#include <string>
#include <vector>

namespace midair::device::autd3
{

/// A network interface with a link-local address.
struct NetworkInterface
{
    std::string name;
    std::uint32_t index = 0;
};

/// Those that units may hang on: up, not the loopback, with an address of fe80::/10.
std::vector<NetworkInterface> linkLocalInterfaces();

/// Reads "[ADDRESS]:PORT", or "[ADDRESS%INTERFACE]:PORT". Returns false if it is none.
bool parseEndpoint(const std::string& text, Endpoint& endpoint);
std::string endpointText(const Endpoint& endpoint);

/// Datagrams over UDP and IPv6, by one socket that isn't connected: answers come from addresses
/// other than the group's.
class UdpLink : public DatagramLink
{
public:
    /// To the units on \a interface, by the group ff02::1. Throws DeviceError if the system has no
    /// socket for that.
    explicit UdpLink(const NetworkInterface& interface);
    /// To units, or emulators of them, whose group is \a group. Throws DeviceError.
    explicit UdpLink(const Endpoint& group);
    ~UdpLink() override;

    UdpLink(const UdpLink&) = delete;
    UdpLink& operator=(const UdpLink&) = delete;

    std::string name() const override { return _name; }
    bool send(const Endpoint& to, const std::vector<std::uint8_t>& bytes) override;
    bool sendToGroup(const std::vector<std::uint8_t>& bytes) override
    {
        return send(_group, bytes);
    }
    bool receive(double until_s, Endpoint& from, std::vector<std::uint8_t>& bytes) override;
    void rest(double until_s) override;
    void wake() override;

private:
    void open();
    void close();
    bool take(Endpoint& from, std::vector<std::uint8_t>& bytes);
    short wait(short wanted, double until_s);

    const std::string _name;
    const Endpoint _group;
    int _socket = -1;
    int _wake = -1;       ///< an eventfd
    bool _isFull = false; ///< the last send() found no room
};

} // namespace midair::device::autd3
