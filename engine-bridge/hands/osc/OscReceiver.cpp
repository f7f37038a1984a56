#include "engine-bridge/hands/osc/OscReceiver.h"

#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <system_error>

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

constexpr double kFirstPause_s = 1.0;
constexpr double kLongestPause_s = 30.0;
constexpr int kTurn_ms = 1;

std::string nameOf(const OscOptions& options)
{
    return fmt::format("osc: {} port {}", options.address, options.port);
}

/// Waits until one of the two is readable, or \a timeout_ms is over (-1: never). Returns true if \a
/// stop is readable.
bool waitFor(int stop, int socket, int timeout_ms)
{
    std::array<pollfd, 2> both = {{{stop, POLLIN, 0}, {socket, POLLIN, 0}}};
    ::poll(both.data(), socket < 0 ? 1 : 2, timeout_ms);
    return both[0].revents != 0;
}

std::string systemError()
{
    return std::generic_category().message(errno);
}

} // namespace

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
    // Both address families store the port at the same place.
    in_port_t port = 0;
    if (family() == AF_INET6)
        port = reinterpret_cast<const sockaddr_in6*>(&_address)->sin6_port;
    else
        port = reinterpret_cast<const sockaddr_in*>(&_address)->sin_port;
    return ntohs(port);
}

bool operator==(const OscOptions& a, const OscOptions& b)
{
    return a.address == b.address && a.port == b.port;
}

std::shared_ptr<OscReceiver> OscReceiver::open(const OscOptions& options)
{
    static base::Mutex mutex;
    static std::vector<std::weak_ptr<OscReceiver>> all;
    const base::Lock lock(mutex);
    all.erase(std::remove_if(all.begin(), all.end(), [](const auto& one) { return one.expired(); }),
              all.end());
    for (const std::weak_ptr<OscReceiver>& one : all)
        if (std::shared_ptr<OscReceiver> known = one.lock(); known && known->_options == options)
            return known;
    auto fresh = std::make_shared<OscReceiver>(options);
    all.push_back(fresh);
    return fresh;
}

OscReceiver::OscReceiver(const OscOptions& options) :
    _options((SocketAddress::parse(options.address, options.port), options)),
    _inbox(nameOf(options)),
    _stop(::eventfd(0, EFD_CLOEXEC)),
    _thread([this] { run(); })
{
}

OscReceiver::~OscReceiver()
{
    const std::uint64_t one = 1;
    // An eventfd takes 8 bytes at once; without this write the thread would never end.
    while (::write(_stop, &one, sizeof one) < 0 && errno == EINTR)
    {
    }
    _thread.join();
    ::close(_stop);
}

bool OscReceiver::bindSocket()
{
    const SocketAddress address = SocketAddress::parse(_options.address, _options.port);
    _socket = ::socket(address.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (_socket >= 0 && ::bind(_socket, address.get(), address.size()) == 0)
    {
        _port = SocketAddress::boundTo(_socket).port();
        return true;
    }
    _inbox.say("can't be listened at (" + systemError() +
               "); no hands. It is tried again; port=.. and address=.. name another");
    if (_socket >= 0) ::close(_socket);
    _socket = -1;
    return false;
}

void OscReceiver::run()
{
    double pause_s = kFirstPause_s;
    while (!bindSocket())
    {
        if (waitFor(_stop, -1, static_cast<int>(1e3 * pause_s))) return;
        pause_s = std::min(2.0 * pause_s, kLongestPause_s);
    }
    receive();
    ::close(_socket);
}

void OscReceiver::receive()
{
    while (!waitFor(_stop, _socket, -1))
    {
        if (takeTurn() < kMostInTurn) continue;
        _inbox.say(fmt::format(
            "more than {} datagrams a millisecond arrive; the rest is lost, and hands may be, too",
            kMostInTurn / kTurn_ms));
        if (waitFor(_stop, -1, kTurn_ms)) return;
    }
}

// Returns the number of datagrams read.
int OscReceiver::takeTurn()
{
    std::array<char, kMostOscBytes + 1> bytes;
    for (int i = 0; i < kMostInTurn; ++i)
    {
        sockaddr_storage from{};
        socklen_t length = sizeof from;
        // MSG_TRUNC: returns the true size of datagrams that don't fit.
        const ssize_t size = ::recvfrom(_socket,
                                        bytes.data(),
                                        bytes.size(),
                                        MSG_DONTWAIT | MSG_TRUNC,
                                        reinterpret_cast<sockaddr*>(&from),
                                        &length);
        if (size < 0) return i;
        const std::string sender(reinterpret_cast<const char*>(&from),
                                 std::min<std::size_t>(length, sizeof from));
        const double now_s = base::steadySeconds();
        if (!_inbox.mayBeOf(sender, now_s))
            _inbox.passOver();
        else
            _inbox.take(bytes.data(), static_cast<std::size_t>(size), sender, now_s);
    }
    return kMostInTurn;
}

std::string OscReceiver::status() const
{
    return _inbox.status() + (_port == 0 ? "; not listening" : "");
}

OscHandSource::OscHandSource(const OscOptions& options, const Eigen::Isometry3d& placement) :
    _receiver(OscReceiver::open(options)),
    _placement(placement)
{
}

bool OscHandSource::frameAt(double time_s, HandFrame& frame)
{
    frame.time_s = time_s;
    if (!_receiver->inbox().latest(base::steadySeconds(), frame)) return false;
    frame = transformed(frame, _placement);
    return true;
}

} // namespace midair::bridge
