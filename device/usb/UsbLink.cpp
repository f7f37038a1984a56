#include "device/usb/UsbLink.h"

#include "haptics/base/threads/SteadyClock.h"

#include <atomic>
#include <cmath>

#include <fmt/format.h>

namespace midair::device
{

using protocol::Packet;
using protocol::Type;

namespace
{

constexpr double kGreeting_s = 0.5;

// A new one each time, so that an answer to an earlier greeting isn't taken for the answer to this
// one.
std::uint32_t newNonce()
{
    static std::atomic<std::uint32_t> count{0};
    const auto now_ns = static_cast<std::uint64_t>(base::steadySeconds() * 1e9);
    return ++count ^ static_cast<std::uint32_t>(now_ns);
}

} // namespace

UsbLink::UsbLink(const UsbAddress& address, const DeviceLayout& layout, Owner& owner) :
    _owner(owner),
    _nonce(newNonce()),
    _pool(std::make_unique<UsbTransferPool>(address, static_cast<Listener&>(*this)))
{
    greet();
    check(layout);
}

void UsbLink::greet()
{
    Packet hello;
    hello.type = Type::HELLO;
    hello.nonce = _nonce;
    hello.watchdog_ms = static_cast<std::uint16_t>(std::lround(protocol::kWatchdog_s * 1000));
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, hello);
    _pool->send(0, bytes);
    const double until_s = base::steadySeconds() + kGreeting_s;
    base::Lock lock(_mutex);
    while (!_greeted && _fault == Outcome::DONE && _heard.waitUntil_s(lock, until_s))
    {
    }
    if (_greeted) return;
    if (_fault != Outcome::DONE)
        throw DeviceError(name() + ": doesn't take the greeting: " + outcomeName(_fault));
    throw DeviceError(
        name() + ": gives no answer that this program understands; is osgMidair's firmware on it?");
}

void UsbLink::check(const DeviceLayout& layout) const
{
    const protocol::Info& info = _info.info;
    if (_info.version != protocol::kVersion)
        throw DeviceError(fmt::format(
            "{}: firmware {} speaks protocol version {}, this program speaks {}: update the {}",
            name(),
            info.firmware(),
            int(_info.version),
            int(protocol::kVersion),
            _info.version < protocol::kVersion ? "firmware" : "program"));
    const std::vector<protocol::Range> ranges = protocol::ranges(layout);
    const int boards = ranges.empty() ? 0 : ranges.back().board + 1;
    if (info.transducers != static_cast<std::uint32_t>(layout.transducers) || info.boards != boards)
        throw DeviceError(
            fmt::format("{}: has {} transducers on {} boards, but the array file has {} on {}",
                        name(),
                        info.transducers,
                        info.boards,
                        layout.transducers,
                        boards));
}

bool UsbLink::send(Type type)
{
    Packet packet;
    packet.type = type;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    return _pool->send(0, bytes);
}

bool UsbLink::mute(std::uint32_t sequence)
{
    Packet packet;
    packet.type = Type::MUTE;
    packet.sequence = sequence;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    return _pool->control(bytes);
}

bool UsbLink::identify(int board, bool light)
{
    Packet packet;
    packet.type = Type::IDENTIFY;
    packet.board = board < 0 ? protocol::kAllBoards : static_cast<std::uint16_t>(board);
    packet.light = light;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    return _pool->control(bytes);
}

void UsbLink::noteFault(Outcome outcome)
{
    {
        const base::Lock lock(_mutex);
        if (_fault != Outcome::LOST) _fault = outcome;
    }
    _heard.notifyAll();
}

void UsbLink::onSent(std::uint64_t token, Outcome outcome)
{
    if (outcome != Outcome::DONE && outcome != Outcome::CANCELLED) noteFault(outcome);
    _owner.onSent(token, outcome);
}

void UsbLink::onReceiveFailed(Outcome outcome)
{
    noteFault(outcome);
    _owner.onReceiveFailed(outcome);
}

void UsbLink::onReceived(const std::uint8_t* bytes, std::size_t count)
{
    _parser.push(bytes, count);
    Packet packet;
    while (_parser.next(packet))
    {
        if (packet.type == Type::INFO && packet.info.nonce == _nonce)
        {
            const base::Lock lock(_mutex);
            if (!_greeted) _info = packet;
            _greeted = true;
        }
        _owner.onAnswer(packet);
    }
    if (_parser.badPackets() != _nonsense)
    {
        const bool first = _nonsense == 0;
        _nonsense = _parser.badPackets();
        _owner.onNonsense(first);
    }
    _heard.notifyAll();
}

} // namespace midair::device
