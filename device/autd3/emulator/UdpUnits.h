#pragma once

#include "device/autd3/emulator/EmulatedChain.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <netinet/in.h>

namespace midair::device::emulation
{

/// Emulated units behind UDP ports of this machine: one for the group, and one for each id, which
/// the system chooses when a unit first answers from it, so that nobody can guess it.
class UdpUnits
{
public:
    /// Listens on \a port of ::1; 0: the system chooses one. Throws DeviceError.
    UdpUnits(const ChainOptions& options, std::uint16_t port);
    ~UdpUnits();
    UdpUnits(const UdpUnits&) = delete;
    UdpUnits& operator=(const UdpUnits&) = delete;

    std::uint16_t port() const { return _port; } ///< of the group
    /// Relays datagrams until the chain's time \a until_ns, or a signal. One thread at a time.
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
    std::vector<Address> _peers; ///< the latest senders, in a ring
    std::uint64_t _nextPeer = 0;
};

} // namespace midair::device::emulation
