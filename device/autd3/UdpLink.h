#pragma once

#include "device/autd3/Autd3Options.h"
#include "device/autd3/DatagramLink.h"
#include "device/autd3/UnitGroup.h"

#include <functional>
#include <memory>
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

/// Returns the interfaces for units: up, not the loopback, with an address in fe80::/10.
std::vector<NetworkInterface> linkLocalInterfaces();

/// Parses "[ADDRESS]:PORT", or "[ADDRESS%INTERFACE]:PORT". Returns false for other texts.
bool parseEndpoint(const std::string& text, Endpoint& endpoint);
std::string endpointText(const Endpoint& endpoint);

/// Datagrams over UDP and IPv6 on an unconnected socket, because answers come from other addresses
/// than the group's.
class UdpLink : public DatagramLink
{
public:
    /// For units on \a interface, by the group ff02::1. Throws DeviceError if the system can't
    /// create the socket.
    explicit UdpLink(const NetworkInterface& interface);
    /// For units, or emulated units, with the group \a group. Throws DeviceError.
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
    void rest(double until_s) override { wait(0, until_s); }
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

/// Returns the device's name in messages: "autd3", with interface or group if given.
std::string deviceName(const Autd3Options& options);

/// Opens the link to the units of \a options: by group, by interface, or by the only interface with
/// answers. Throws DeviceError, which names the interfaces tried or answering, also when \a isLeft
/// returns true.
std::unique_ptr<DatagramLink>
chooseLink(const Autd3Options& options, Refusals& refusals, const std::function<bool()>& isLeft);

/// Units that answer on an interface.
struct UnitsListing
{
    std::string interface;
    int units = 0;        ///< at least 1; units behind a closed port don't answer
    std::string firmware; ///< of one of them; empty: another protocol
};

/// Asks on all interfaces, 0.1 s each and up to three times; changes nothing on the units.
std::vector<UnitsListing> listUnits();

} // namespace midair::device::autd3
