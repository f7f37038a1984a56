#include "tests/vm/UsbIpServer.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace
{

constexpr std::uint32_t kSubmit = 1;
constexpr std::uint32_t kUnlink = 2;
constexpr std::uint32_t kSubmitted = 3;
constexpr std::uint32_t kUnlinked = 4;
constexpr std::size_t kHeaderBytes = 48;
constexpr std::uint32_t kOut = 3;
constexpr std::uint32_t kIn = 6;
constexpr std::uint32_t kFifoOut = 2;

constexpr std::uint8_t kDevice[] = {
    18, 1, 0, 2, 0, 0, 0, 64, 0x09, 0x12, 0x01, 0x00, 0, 1, 1, 2, 3, 1};
// Interface 0 is something else; the array is interface 1, bulk OUT 3, bulk IN 6.
constexpr std::uint8_t kConfiguration[] = {
    9, 2, 41,   0,    2,    1, 0, 0x80, 50,   9, 4, 0, 0, 0, 0xFF, 0,    0, 0, 9, 4, 1,
    0, 2, 0xFF, 0x4D, 0x48, 0, 7, 5,    0x03, 2, 0, 2, 0, 7, 5,    0x86, 2, 0, 2, 0};

constexpr std::uint8_t kFifoDevice[] = {
    18, 1, 0, 2, 0, 0, 0, 64, 0x03, 0x04, 0x14, 0x60, 0, 9, 1, 2, 3, 1};
// One interface, bulk IN 1, bulk OUT 2.
constexpr std::uint8_t kFifoConfiguration[] = {9, 2, 32, 0,    1,    1,    0, 0x80, 50, 9,    4,
                                               0, 0, 2,  0xFF, 0xFF, 0xFF, 0, 7,    5,  0x81, 2,
                                               0, 2, 0,  7,    5,    0x02, 2, 0,    2,  0};

void put(std::vector<std::uint8_t>& out, std::uint32_t value)
{
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::uint32_t get(const std::uint8_t* bytes)
{
    return std::uint32_t(bytes[0]) << 24 | std::uint32_t(bytes[1]) << 16 |
           std::uint32_t(bytes[2]) << 8 | bytes[3];
}

bool readAll(int socket, std::uint8_t* bytes, std::size_t count)
{
    while (count > 0)
    {
        const ssize_t got = ::read(socket, bytes, count);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        bytes += got;
        count -= static_cast<std::size_t>(got);
    }
    return true;
}

} // namespace

UsbIpServer::UsbIpServer(midair::device::VirtualFirmware& firmware) :
    _firmware(&firmware),
    _take([&firmware](const std::uint8_t* bytes, std::size_t count)
          { firmware.receive(bytes, count, now_s()); })
{
}

UsbIpServer::UsbIpServer(Take take) : _take(std::move(take)) {}

double UsbIpServer::now_s()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

bool UsbIpServer::plug()
{
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return false;
    const int attach = ::open("/sys/devices/platform/vhci_hcd.0/attach", O_WRONLY);
    const std::string number = _firmware != nullptr ? "0" : "1";
    const std::string text = number + " " + std::to_string(ends[1]) + " " +
                             (_firmware != nullptr ? "65538" : "65539") +
                             " 3"; // port, socket, bus 1 device 2 or 3, high speed
    const bool taken = attach >= 0 && ::write(attach, text.data(), text.size()) ==
                                          static_cast<ssize_t>(text.size());
    if (attach >= 0) ::close(attach);
    ::close(ends[1]); // the kernel holds it
    _socket = ends[0];
    _stop = false;
    if (_firmware != nullptr) _firmware->powerCycle(now_s());
    _thread = std::thread([this] { run(); });
    return taken;
}

void UsbIpServer::unplug()
{
    if (!_thread.joinable()) return;
    _stop = true;
    _thread.join();
    ::close(_socket);
    _waitingIn.clear();
}

void UsbIpServer::run()
{
    while (!_stop)
    {
        feedIn();
        pollfd wait{_socket, POLLIN, 0};
        if (::poll(&wait, 1, 1) <= 0) continue;
        Header header;
        if (!readHeader(header)) return;
        if (header.command == kSubmit)
            submit(header);
        else
            unlink(header);
    }
}

bool UsbIpServer::readHeader(Header& header)
{
    std::uint8_t bytes[kHeaderBytes];
    if (!readAll(_socket, bytes, sizeof bytes)) return false;
    header.command = get(bytes);
    header.sequence = get(bytes + 4);
    header.direction = get(bytes + 12);
    header.endpoint = get(bytes + 16);
    header.length = header.command == kSubmit ? get(bytes + 24) : get(bytes + 20);
    std::copy(bytes + 40, bytes + 48, header.setup);
    return true;
}

void UsbIpServer::answer(const Header& header,
                         int status,
                         const std::uint8_t* data,
                         std::size_t count)
{
    std::vector<std::uint8_t> out;
    put(out, kSubmitted);
    put(out, header.sequence);
    for (int i = 0; i < 3; ++i)
        put(out, 0);
    put(out, static_cast<std::uint32_t>(status));
    put(out, static_cast<std::uint32_t>(header.direction == 1 ? count : header.length));
    out.resize(kHeaderBytes);
    if (header.direction == 1) out.insert(out.end(), data, data + count);
    (void)!::send(_socket, out.data(), out.size(), MSG_NOSIGNAL);
}

void UsbIpServer::submit(const Header& header)
{
    std::vector<std::uint8_t> data;
    if (header.direction == 0)
    {
        data.resize(header.length);
        if (!readAll(_socket, data.data(), data.size())) return;
    }
    if (header.endpoint == 0) return control(header, data);
    if (_firmware != nullptr && header.endpoint == kIn && header.direction == 1)
    {
        _waitingIn.push_back(header);
        return;
    }
    if (header.endpoint != (_firmware != nullptr ? kOut : kFifoOut) || header.direction == 1)
        return answer(header, -EPIPE, nullptr, 0);
    std::lock_guard<std::mutex> lock(_mutex);
    if (_holding)
        _held.push_back({header, data});
    else
        receive(header, data);
}

void UsbIpServer::receive(const Header& header, const std::vector<std::uint8_t>& data)
{
    _take(data.data(), data.size());
    answer(header, 0, nullptr, 0);
}

void UsbIpServer::hold()
{
    std::lock_guard<std::mutex> lock(_mutex);
    _holding = true;
}

void UsbIpServer::letGo()
{
    std::lock_guard<std::mutex> lock(_mutex);
    _holding = false;
    for (const Held& held : std::exchange(_held, {}))
        receive(held.header, held.data);
}

std::size_t UsbIpServer::held()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _held.size();
}

int UsbIpServer::unlinkedHeld()
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _unlinkedHeld;
}

void UsbIpServer::control(const Header& header, const std::vector<std::uint8_t>& data)
{
    const std::uint8_t* setup = header.setup;
    const std::size_t asked = setup[6] + 256U * setup[7];
    const auto give = [&](const std::uint8_t* bytes, std::size_t count)
    { answer(header, 0, bytes, std::min(count, asked)); };
    if (setup[0] == 0x80 && setup[1] == 6)
    {
        const std::uint8_t languages[] = {4, 3, 9, 4};
        const std::uint8_t serial[] = {12, 3, 'A', 0, '0', 0, '0', 0, '0', 0, '1', 0};
        switch (setup[3])
        {
        case 1:
            return _firmware != nullptr ? give(kDevice, sizeof kDevice)
                                        : give(kFifoDevice, sizeof kFifoDevice);
        case 2:
            return _firmware != nullptr ? give(kConfiguration, sizeof kConfiguration)
                                        : give(kFifoConfiguration, sizeof kFifoConfiguration);
        case 3:
            return setup[2] == 0 ? give(languages, sizeof languages) : give(serial, sizeof serial);
        default:
            return answer(header, -EPIPE, nullptr, 0);
        }
    }
    if (_firmware != nullptr && setup[0] == 0x41 && setup[1] == 0x4D)
        _take(data.data(), data.size());
    const std::uint8_t zeros[2] = {};
    if (header.direction == 1)
        give(zeros, sizeof zeros);
    else
        answer(header, 0, nullptr, 0); // set configuration, set interface, clear feature
}

void UsbIpServer::unlink(const Header& header)
{
    const auto waiting =
        std::find_if(_waitingIn.begin(),
                     _waitingIn.end(),
                     [&](const Header& one) { return one.sequence == header.length; });
    bool found = waiting != _waitingIn.end();
    if (found) _waitingIn.erase(waiting);
    std::lock_guard<std::mutex> lock(_mutex);
    for (auto held = _held.begin(); !found && held != _held.end(); ++held)
        if (held->header.sequence == header.length)
        {
            found = true;
            ++_unlinkedHeld;
            _held.erase(held);
            break;
        }
    std::vector<std::uint8_t> out;
    put(out, kUnlinked);
    put(out, header.sequence);
    for (int i = 0; i < 3; ++i)
        put(out, 0);
    put(out, static_cast<std::uint32_t>(found ? -ECONNRESET : 0));
    out.resize(kHeaderBytes);
    (void)!::send(_socket, out.data(), out.size(), MSG_NOSIGNAL);
}

void UsbIpServer::feedIn()
{
    while (_firmware != nullptr && !_waitingIn.empty() && _firmware->hasAnswer(now_s()))
    {
        const Header header = _waitingIn.front();
        _waitingIn.pop_front();
        const auto bytes = _firmware->takeAnswer(header.length, now_s());
        answer(header, 0, bytes.data(), bytes.size());
    }
}
