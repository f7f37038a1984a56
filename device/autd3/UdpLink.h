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

/// "autd3", with the interface or group where one is named: what messages call the device.
std::string deviceName(const Autd3Options& options);

/// Opens the way to the units that \a options name: by their group, by their interface, or by the
/// one interface that units answer on. Throws DeviceError, which names the interfaces that were
/// tried or that have answers, also as soon as \a isLeft returns true.
std::unique_ptr<DatagramLink>
chooseLink(const Autd3Options& options, Refusals& refusals, const std::function<bool()>& isLeft);

/// Units that answer on an interface.
struct UnitsListing
{
    std::string interface;
    int units = 0;        ///< at least 1; those behind a way that is closed don't answer
    std::string firmware; ///< of one of them; empty: it speaks another protocol
};

/// Asks on all interfaces, 0.1 s each and up to three times; changes nothing at the units.
std::vector<UnitsListing> listUnits();

} // namespace midair::device::autd3
