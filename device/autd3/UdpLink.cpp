#include "device/autd3/UdpLink.h"

#include "device/ArrayDevice.h"
#include "device/autd3/protocol/Messages.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <vector>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::device::autd3
{

namespace
{

// Keeps at most about 5 ms of line time in the system's queues, some of which drop the rest.
constexpr int kSendBuffer = 8192;
constexpr int kReceiveBuffer = 1 << 20; // answers of 64 units while this thread doesn't run
constexpr std::size_t kMostReceived = 2048;

std::string reason()
{
    return std::generic_category().message(errno);
}

sockaddr_in6 socketAddress(const Endpoint& endpoint)
{
    sockaddr_in6 address{};
    address.sin6_family = AF_INET6;
    address.sin6_port = htons(endpoint.port);
    address.sin6_scope_id = endpoint.scope;
    std::memcpy(&address.sin6_addr, endpoint.address.data(), endpoint.address.size());
    return address;
}

Endpoint allNodes(std::uint32_t index)
{
    Endpoint group;
    group.address = {0xFF, 0x02};
    group.address.back() = 1;
    group.port = kPort;
    group.scope = index;
    return group;
}

constexpr double kLinkAnswer_s = 0.1;
constexpr int kLinkTries = 3;
constexpr std::uint16_t kNumber = 0x4D44;

// Any answer of the protocol is accepted, even a refusal. Returns the answers to the first question
// that gets one.
std::vector<Answer>
askAll(DatagramLink& link, Refusals& refusals, const std::function<bool()>& isLeft)
{
    Endpoint from;
    std::vector<std::uint8_t> bytes;
    std::vector<Answer> answers;
    for (int i = 0; i < kLinkTries && answers.empty() && !isLeft(); ++i)
    {
        if (!link.sendToGroup(message(Kind::READ_UNIT_INFO, kNumber))) continue;
        const double until_s = link.now_s() + kLinkAnswer_s;
        while (link.now_s() < until_s)
        {
            Answer answer;
            std::string error;
            if (!link.receive(until_s, from, bytes)) continue;
            if (readAnswer(bytes, answer, error) && answer.kind == Kind::READ_UNIT_INFO &&
                answer.number == kNumber)
                answers.push_back(std::move(answer));
            else
                refusals.add(error.empty() ? Refusal::STRAY : Refusal::MALFORMED,
                             endpointText(from) + ": " + error,
                             link.now_s());
        }
    }
    return answers;
}

std::string namesOf(const std::vector<NetworkInterface>& interfaces)
{
    std::string names;
    for (const NetworkInterface& one : interfaces)
        names += (names.empty() ? "" : ", ") + one.name;
    return names;
}

std::unique_ptr<DatagramLink> named(const Autd3Options& options)
{
    const std::vector<NetworkInterface> all = linkLocalInterfaces();
    const auto one =
        std::find_if(all.begin(),
                     all.end(),
                     [&](const NetworkInterface& i) { return i.name == options.interface; });
    if (one == all.end())
        throw DeviceError(fmt::format("{}: interface={} doesn't exist, is down or has no "
                                      "link-local IPv6 address; available: {}",
                                      deviceName(options),
                                      options.interface,
                                      all.empty() ? "none" : namesOf(all)));
    return std::make_unique<UdpLink>(*one);
}

} // namespace

std::vector<NetworkInterface> linkLocalInterfaces()
{
    std::vector<NetworkInterface> found;
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return found;
    for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next)
    {
        if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET6) continue;
        if ((one->ifa_flags & IFF_UP) == 0 || (one->ifa_flags & IFF_LOOPBACK) != 0) continue;
        sockaddr_in6 address{};
        std::memcpy(&address, one->ifa_addr, sizeof address);
        if (!IN6_IS_ADDR_LINKLOCAL(&address.sin6_addr)) continue;
        const bool isKnown =
            std::any_of(found.begin(),
                        found.end(),
                        [&](const NetworkInterface& other) { return other.name == one->ifa_name; });
        if (!isKnown) found.push_back({one->ifa_name, ::if_nametoindex(one->ifa_name)});
    }
    ::freeifaddrs(all);
    return found;
}

bool parseEndpoint(const std::string& text, Endpoint& endpoint)
{
    const std::size_t end = text.rfind("]:");
    if (text.empty() || text.front() != '[' || end == std::string::npos) return false;
    std::string address = text.substr(1, end - 1);
    Endpoint read;
    const std::size_t percent = address.find('%');
    if (percent != std::string::npos)
    {
        read.scope = ::if_nametoindex(address.substr(percent + 1).c_str());
        if (read.scope == 0) return false;
        address.resize(percent);
    }
    int port = 0;
    if (!base::parseWhole(text.substr(end + 2), port) || port < 1 || port > 65535) return false;
    read.port = static_cast<std::uint16_t>(port);
    if (::inet_pton(AF_INET6, address.c_str(), read.address.data()) != 1) return false;
    endpoint = read;
    return true;
}

std::string endpointText(const Endpoint& endpoint)
{
    char text[INET6_ADDRSTRLEN] = "";
    char name[IF_NAMESIZE] = "";
    ::inet_ntop(AF_INET6, endpoint.address.data(), text, sizeof text);
    const bool isScoped = endpoint.scope != 0 && ::if_indextoname(endpoint.scope, name) != nullptr;
    return fmt::format("[{}{}{}]:{}", text, isScoped ? "%" : "", name, endpoint.port);
}

UdpLink::UdpLink(const NetworkInterface& interface) :
    _name(interface.name),
    _group(allNodes(interface.index))
{
    open();
}

UdpLink::UdpLink(const Endpoint& group) : _name(endpointText(group)), _group(group)
{
    open();
}

UdpLink::~UdpLink()
{
    close();
}

void UdpLink::open()
{
    _wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    _socket = ::socket(AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int index = static_cast<int>(_group.scope);
    const int hops = 1;
    bool isOpen = _wake >= 0 && _socket >= 0;
    isOpen = isOpen && ::setsockopt(_socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof(int)) == 0;
    isOpen =
        isOpen && ::setsockopt(_socket, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof(int)) == 0;
    isOpen =
        isOpen && ::setsockopt(_socket, IPPROTO_IPV6, IPV6_MULTICAST_HOPS, &hops, sizeof hops) == 0;
    if (index != 0)
        isOpen = isOpen &&
                 ::setsockopt(_socket, IPPROTO_IPV6, IPV6_MULTICAST_IF, &index, sizeof index) == 0;
    if (isOpen) return;
    const std::string why = reason();
    close();
    throw DeviceError(fmt::format("autd3: no socket for {}: {}", _name, why));
}

void UdpLink::close()
{
    if (_socket >= 0) ::close(_socket);
    if (_wake >= 0) ::close(_wake);
    _socket = _wake = -1;
}

bool UdpLink::send(const Endpoint& to, const std::vector<std::uint8_t>& bytes)
{
    const sockaddr_in6 address = socketAddress(to);
    ssize_t sent = 0;
    do
        sent = ::sendto(_socket,
                        bytes.data(),
                        bytes.size(),
                        0,
                        reinterpret_cast<const sockaddr*>(&address),
                        sizeof address);
    while (sent < 0 && errno == EINTR);
    // The system reports an emulator's closed port at the next send, which it refuses.
    _isFull = sent < 0 && (errno == EAGAIN || errno == ENOBUFS);
    return sent == static_cast<ssize_t>(bytes.size());
}

bool UdpLink::take(Endpoint& from, std::vector<std::uint8_t>& bytes)
{
    bytes.resize(kMostReceived);
    sockaddr_in6 address{};
    socklen_t size = sizeof address;
    const ssize_t received = ::recvfrom(
        _socket, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&address), &size);
    if (received < 0) return false; // nothing available, or a closed port was reported
    bytes.resize(static_cast<std::size_t>(received));
    std::memcpy(from.address.data(), &address.sin6_addr, from.address.size());
    from.port = ntohs(address.sin6_port);
    from.scope = address.sin6_scope_id;
    return true;
}

bool UdpLink::receive(double until_s, Endpoint& from, std::vector<std::uint8_t>& bytes)
{
    if (take(from, bytes)) return true;
    const auto wanted = static_cast<short>(_isFull ? POLLIN | POLLOUT : POLLIN);
    const short events = wait(wanted, until_s);
    if (events != 0) _isFull = false;
    return (events & POLLIN) != 0 && take(from, bytes);
}

// Returns which of the wanted socket events occurred.
short UdpLink::wait(short wanted, double until_s)
{
    const double wait_s = std::max(0.0, until_s - base::steadySeconds());
    timespec time{};
    time.tv_sec = static_cast<time_t>(wait_s);
    time.tv_nsec = static_cast<long>((wait_s - static_cast<double>(time.tv_sec)) * 1e9);
    // A negative descriptor is ignored; otherwise socket errors would also end the wait.
    pollfd waits[] = {{wanted != 0 ? _socket : -1, wanted, 0}, {_wake, POLLIN, 0}};
    if (::ppoll(waits, 2, &time, nullptr) <= 0) return 0;
    if (waits[1].revents != 0)
    {
        std::uint64_t count = 0;
        (void)!::read(_wake, &count, sizeof count);
    }
    return waits[0].revents;
}

void UdpLink::wake()
{
    const std::uint64_t one = 1;
    (void)!::write(_wake, &one, sizeof one);
}

std::string deviceName(const Autd3Options& options)
{
    if (!options.group.empty()) return "autd3 at " + options.group;
    return options.interface.empty() ? "autd3" : "autd3 on " + options.interface;
}

std::unique_ptr<DatagramLink>
chooseLink(const Autd3Options& options, Refusals& refusals, const std::function<bool()>& isLeft)
{
    if (!options.group.empty())
    {
        Endpoint group;
        if (!parseEndpoint(options.group, group))
            throw DeviceError(fmt::format(
                "autd3: group={} should be [ADDRESS]:PORT, such as [::1]:44336", options.group));
        return std::make_unique<UdpLink>(group);
    }
    if (!options.interface.empty()) return named(options);
    const std::vector<NetworkInterface> all = linkLocalInterfaces();
    std::vector<NetworkInterface> found;
    std::unique_ptr<UdpLink> chosen;
    for (const NetworkInterface& one : all)
    {
        auto link = std::make_unique<UdpLink>(one);
        if (askAll(*link, refusals, isLeft).empty()) continue;
        found.push_back(one);
        chosen = std::move(link);
    }
    if (found.size() > 1)
        throw DeviceError(fmt::format("autd3: units answer on {}; choose one with interface=NAME",
                                      namesOf(found)));
    if (found.empty() && all.empty())
        throw DeviceError("autd3: no network interface is up with a link-local IPv6 address");
    if (found.empty())
        throw DeviceError(fmt::format("autd3: no unit answers on {}: units need some seconds after "
                                      "power-on, and a firewall must let UDP from port {} in",
                                      namesOf(all),
                                      kPort));
    return chosen;
}

std::vector<UnitsListing> listUnits()
{
    std::vector<UnitsListing> found;
    Refusals refusals("autd3");
    for (const NetworkInterface& one : linkLocalInterfaces())
        try
        {
            UdpLink link(one);
            const std::vector<Answer> answers = askAll(link, refusals, [] { return false; });
            if (answers.empty()) continue;
            const Answer& first = answers.front();
            const bool isSpoken = first.version == kProtocolVersion && first.status == 0;
            found.push_back({one.name,
                             static_cast<int>(answers.size()),
                             isSpoken ? first.info.firmware.text() : std::string()});
        }
        catch (const DeviceError&) // it has disappeared since
        {
        }
    return found;
}

} // namespace midair::device::autd3
