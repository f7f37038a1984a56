#pragma once

#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// An IPv6 address and port, and the interface that a link-local address belongs to.
struct Endpoint
{
    std::array<std::uint8_t, 16> address{}; ///< in the order of the wire
    std::uint16_t port = 0;
    std::uint32_t scope = 0; ///< number of the interface; 0: the address needs none

    bool operator==(const Endpoint& other) const
    {
        return address == other.address && port == other.port && scope == other.scope;
    }
    bool operator!=(const Endpoint& other) const { return !(*this == other); }
};

constexpr std::size_t kMostDatagramBytes = 1452; ///< of the payload: never fragmented by MTU 1500

/// Sends datagrams to units, or to all of them, and waits for answers.
///
/// Everything but wake() is called by one thread at a time.
class DatagramLink
{
public:
    virtual ~DatagramLink() = default;

    virtual std::string name() const = 0; ///< for messages: "eth0", "[::1]:44336"
    /// The time that all else here is told in, s. Of emulated units it may pass faster. Any thread.
    virtual double now_s() const { return base::steadySeconds(); }

    /// Sends \a bytes (1 .. kMostDatagramBytes) to \a to. Returns false if it was not sent, since
    /// there is no room now or no way: the caller may try again. Never waits.
    virtual bool send(const Endpoint& to, const std::vector<std::uint8_t>& bytes) = 0;
    /// The same to the group that all units listen to.
    virtual bool sendToGroup(const std::vector<std::uint8_t>& bytes) = 0;

    /// Waits until a datagram comes, and returns true with its sender and bytes (of any length, 0
    /// included); or until \a until_s, wake(), or room after a send() that failed, and returns
    /// false. A time that is past doesn't wait, and takes what is there.
    virtual bool receive(double until_s, Endpoint& from, std::vector<std::uint8_t>& bytes) = 0;

    /// Waits until \a until_s or wake(); leaves datagrams for the next receive().
    virtual void rest(double until_s) = 0;

    /// Ends the receive() or rest() that waits, or the next one. Any thread.
    virtual void wake() = 0;
};

} // namespace midair::device::autd3
