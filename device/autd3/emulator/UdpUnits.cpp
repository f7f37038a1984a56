#include "device/autd3/emulator/UdpUnits.h"

#include "device/ArrayDevice.h"
#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::device::emulation
{

namespace
{

constexpr std::size_t kMostPeers = 256;
constexpr int kMostAtOnce = 256; // datagrams from one port before the next
constexpr int kBufferBytes = 1 << 20;

} // namespace

Time_ns UdpUnits::now_ns()
{
    return static_cast<Time_ns>(base::steadySeconds() * 1e9);
}

UdpUnits::UdpUnits(const ChainOptions& options, std::uint16_t port) : _chain(options, now_ns())
{
    _group = open(port, _port);
    if (_group < 0)
        throw DeviceError(fmt::format("emulated units: port {} of ::1 can't be opened: {}; another "
                                      "emulator may use it, choose one with --port",
                                      port,
                                      std::generic_category().message(errno)));
}

UdpUnits::~UdpUnits()
{
    if (_group >= 0) close(_group);
    for (const auto& [id, socket] : _sockets)
        close(socket);
}

int UdpUnits::open(std::uint16_t port, std::uint16_t& chosen)
{
    const int opened = socket(AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (opened < 0) return -1;
    setsockopt(opened, SOL_SOCKET, SO_RCVBUF, &kBufferBytes, sizeof kBufferBytes);
    Address address{};
    address.sin6_family = AF_INET6;
    address.sin6_addr = in6addr_loopback;
    address.sin6_port = htons(port);
    socklen_t length = sizeof address;
    if (bind(opened, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        getsockname(opened, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    {
        const int error = errno;
        close(opened);
        errno = error;
        return -1;
    }
    chosen = ntohs(address.sin6_port);
    return opened;
}

int UdpUnits::socketOf(int id)
{
    const auto found = _sockets.find(id);
    if (found != _sockets.end()) return found->second;
    std::uint16_t chosen = 0;
    const int opened = open(0, chosen);
    if (opened >= 0) _sockets[id] = opened;
    return opened;
}

std::uint64_t UdpUnits::peerOf(const Address& address)
{
    for (std::size_t i = 0; i < _peers.size(); ++i)
        if (_peers[i].sin6_port == address.sin6_port &&
            std::memcmp(&_peers[i].sin6_addr, &address.sin6_addr, sizeof address.sin6_addr) == 0)
            return i;
    if (_peers.size() < kMostPeers)
    {
        _peers.push_back(address);
        return _peers.size() - 1;
    }
    _peers[_nextPeer % kMostPeers] = address;
    return _nextPeer++ % kMostPeers;
}

void UdpUnits::takeAll(int socket, int to)
{
    std::array<std::uint8_t, 2048> bytes{};
    for (int i = 0; i < kMostAtOnce; ++i)
    {
        Address from{};
        socklen_t length = sizeof from;
        const ssize_t size = recvfrom(
            socket, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
        if (size < 0) return;
        _chain.send(to, bytes.data(), static_cast<std::size_t>(size), peerOf(from), now_ns());
    }
}

void UdpUnits::giveAll()
{
    EmulatedChain::Answer answer;
    while (_chain.receive(answer, now_ns()))
    {
        // A foreign sender has a port that belongs to no id.
        const int socket = socketOf(answer.from);
        if (socket < 0 || answer.peer >= _peers.size()) continue;
        const Address& to = _peers[answer.peer];
        // An answer that can't be sent is lost, as on a cable.
        sendto(socket,
               answer.bytes.data(),
               answer.bytes.size(),
               0,
               reinterpret_cast<const sockaddr*>(&to),
               sizeof to);
    }
}

void UdpUnits::run(Time_ns until_ns)
{
    for (Time_ns time_ns = now_ns(); time_ns < until_ns; time_ns = now_ns())
    {
        giveAll();
        std::vector<pollfd> ports = {{_group, POLLIN, 0}};
        std::vector<int> ids = {kGroup};
        for (const auto& [id, socket] : _sockets)
        {
            ports.push_back({socket, POLLIN, 0});
            ids.push_back(id);
        }
        const Time_ns wait_ns =
            std::max<Time_ns>(0, std::min(until_ns, _chain.nextEvent_ns()) - now_ns());
        timespec wait{};
        wait.tv_sec = static_cast<time_t>(wait_ns / 1'000'000'000);
        wait.tv_nsec = static_cast<long>(wait_ns % 1'000'000'000);
        const int ready = ppoll(ports.data(), ports.size(), &wait, nullptr);
        if (ready < 0) return; // a signal
        for (std::size_t i = 0; i < ports.size(); ++i)
            if ((ports[i].revents & POLLIN) != 0) takeAll(ports[i].fd, ids[i]);
    }
}

} // namespace midair::device::emulation
