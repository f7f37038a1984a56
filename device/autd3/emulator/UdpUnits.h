#pragma once

#include "device/autd3/emulator/EmulatedChain.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <netinet/in.h>

namespace midair::device::emulation
{

/// Emulated units behind UDP ports of this machine: one that stands for the group, and one for each
/// id, which the system chooses when a unit first answers from it, so that nobody can make it up.
class UdpUnits
{
public:
    /// Listens on \a port of ::1; 0: one that the system chooses. Throws DeviceError.
    UdpUnits(const ChainOptions& options, std::uint16_t port);
    ~UdpUnits();
    UdpUnits(const UdpUnits&) = delete;
    UdpUnits& operator=(const UdpUnits&) = delete;

    std::uint16_t port() const { return _port; } ///< of the group
    /// Passes datagrams on until the chain's time \a until_ns, or a signal comes. One thread at a
    /// time.
    void run(Time_ns until_ns);
    EmulatedChain& chain() { return _chain; }
    static Time_ns now_ns(); ///< the steady clock's

private:
    using Address = sockaddr_in6;

    int open(std::uint16_t port, std::uint16_t& chosen);
    int socketOf(int id);
    void takeAll(int socket, int to);
    void giveAll();
    std::uint64_t peerOf(const Address& address);

    EmulatedChain _chain;
    std::uint16_t _port = 0;
    int _group = -1;
    std::map<int, int> _sockets; ///< by id
    std::vector<Address> _peers; ///< the last ones that sent something, in a ring
    std::uint64_t _nextPeer = 0;
};

} // namespace midair::device::emulation
