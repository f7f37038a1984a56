#pragma once

#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// An IPv6 address and port, and the interface of a link-local address.
struct Endpoint
{
    std::array<std::uint8_t, 16> address{}; ///< in network order
    std::uint16_t port = 0;
    std::uint32_t scope = 0; ///< interface number; 0: not needed

    bool operator==(const Endpoint& other) const
    {
        return address == other.address && port == other.port && scope == other.scope;
    }
    bool operator!=(const Endpoint& other) const { return !(*this == other); }
};

constexpr std::size_t kMostDatagramBytes = 1452; ///< of payload: never fragmented with MTU 1500

/// Sends datagrams to one or all units, and waits for answers.
///
/// Only one thread at a time may call the members, except wake().
class DatagramLink
{
public:
    virtual ~DatagramLink() = default;

    virtual std::string name() const = 0; ///< for messages: "eth0", "[::1]:44336"
    /// Time base of this link, s. For emulated units it may run faster. Any thread.
    virtual double now_s() const { return base::steadySeconds(); }

    /// Sends \a bytes (1 .. kMostDatagramBytes) to \a to. Returns false if there is no room or no
    /// route now; the caller may retry. Never waits.
    virtual bool send(const Endpoint& to, const std::vector<std::uint8_t>& bytes) = 0;
    /// Sends to the group that all units listen to.
    virtual bool sendToGroup(const std::vector<std::uint8_t>& bytes) = 0;

    /// Waits for a datagram and returns true with its sender and bytes (any length, including 0).
    /// Returns false at \a until_s, on wake(), or when there is room after a failed send(). With a
    /// past time it only takes a datagram that is already there.
    virtual bool receive(double until_s, Endpoint& from, std::vector<std::uint8_t>& bytes) = 0;

    /// Waits until \a until_s or wake(); leaves datagrams for the next receive().
    virtual void rest(double until_s) = 0;

    /// Ends the present or next receive() or rest(). Any thread.
    virtual void wake() = 0;
};

} // namespace midair::device::autd3
