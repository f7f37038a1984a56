#include "device/usb/UsbArrayDevice.h"

#include "device/DeviceUri.h"
#include "device/DriveEncoder.h"
#include "haptics/base/text/Number.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <spdlog/spdlog.h>

namespace midair::device
{

using Outcome = UsbTransferPool::Outcome;
using protocol::Packet;
using protocol::Type;
namespace
{

constexpr double kGreeting_s = 0.5;
constexpr double kFarewell_s = 0.2;

std::chrono::duration<double> seconds(double s)
{
    return std::chrono::duration<double>(s);
}

bool parseHexadecimal(const std::string& text, std::uint16_t& value)
{
    const char* const end = text.data() + text.size();
    return std::from_chars(text.data(), end, value, 16).ptr == end;
}

} // namespace

UsbArrayDevice::Options UsbArrayDevice::takeOptions(DeviceUri& uri)
{
    Options options;
    options.address.serial = uri.path();
    options.wait = uri.takeFlag("wait", false);
    const std::string id = uri.takeText("id", "");
    if (!id.empty())
    {
        std::uint16_t& vendor = options.address.vendor;
        std::uint16_t& product = options.address.product;
        if (id.size() != 9 || id[4] != ':' || !parseHexadecimal(id.substr(0, 4), vendor) ||
            !parseHexadecimal(id.substr(5), product))
            throw uri.error("id=" + id +
                            " should be vendor and product in hexadecimal, such as 1209:0001");
    }
    return options;
}

UsbArrayDevice::UsbArrayDevice(const DeviceLayout& layout, const Options& options) :
    _layout(layout),
    _options(options),
    _ranges(protocol::ranges(layout)),
    _name("usb:" + options.address.serial)
{
    _playing.phase.assign(layout.transducers, 0);
    _playing.duty.assign(layout.transducers, 0);
    try
    {
        connect();
    }
    catch (const DeviceError& error)
    {
        if (!options.wait) throw;
        note(error.what());
        _counters.change([](DeviceReport& report) { report.state = DeviceState::LOST; });
        spdlog::warn("{}; waiting for it", error.what());
    }
    _thread = std::thread([this] { run(); });
}

UsbArrayDevice::~UsbArrayDevice()
{
    _seat->close();
    UsbArrayDevice::silence();
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _heard.wait_for(lock, seconds(kFarewell_s), [&] { return _muteAwaited == 0 || !_ready; });
        _closing = true;
    }
    _wake.notify_all();
    _thread.join();
    std::unique_ptr<UsbTransferPool> pool;
    {
        std::lock_guard<std::mutex> lock(_mutex);
        pool = std::move(_pool);
    }
}

std::uint32_t UsbArrayDevice::nextSequence()
{
    if (++_sequence == 0) ++_sequence; // 0 means none
    return _sequence;
}

void UsbArrayDevice::note(const std::string& fault)
{
    _counters.change(
        [&](DeviceReport& report)
        {
            ++report.faults;
            report.message = fault;
        });
}

void UsbArrayDevice::connect()
{
    Packet hello;
    hello.type = Type::HELLO;
    {
        std::lock_guard<std::mutex> lock(_mutex);
        hello.nonce = ++_nonce ^ static_cast<std::uint32_t>(
                                     std::chrono::steady_clock::now().time_since_epoch().count());
        _nonce = hello.nonce;
        _greeted = false;
        _sequence = 0;
        _fault = Outcome::DONE;
        _faultsInRow = 0;
        _status = protocol::Status();
        _muteAwaited = 0;
        _asked = 0;
        _parser = protocol::StreamParser();
        _nonsense = 0;
    }
    auto pool = std::make_unique<UsbTransferPool>(_options.address, *this);
    hello.watchdog_ms = static_cast<std::uint16_t>(std::lround(protocol::kWatchdog_s * 1000));
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, hello);
    pool->send(0, bytes);
    std::unique_lock<std::mutex> lock(_mutex);
    const bool answered = _heard.wait_for(
        lock, seconds(kGreeting_s), [&] { return _greeted || _fault != Outcome::DONE; });
    const Packet info = _info;
    const Outcome fault = _fault;
    const bool greeted = answered && _greeted;
    lock.unlock();
    if (!greeted && fault != Outcome::DONE)
        throw DeviceError(pool->name() + ": doesn't take the greeting: " + outcomeName(fault));
    if (!greeted)
        throw DeviceError(
            pool->name() +
            ": gives no answer that this program understands; is osgMidair's firmware on it?");
    if (info.version != protocol::kVersion)
        throw DeviceError(pool->name() + ": firmware " + info.info.firmware() +
                          " speaks protocol version " + std::to_string(info.version) +
                          ", this program speaks " + std::to_string(protocol::kVersion) +
                          ": update the " +
                          (info.version < protocol::kVersion ? "firmware" : "program"));
    const int boards = _ranges.empty() ? 0 : _ranges.back().board + 1;
    if (info.info.transducers != static_cast<std::uint32_t>(_layout.transducers) ||
        info.info.boards != boards)
        throw DeviceError(pool->name() + ": has " + std::to_string(info.info.transducers) +
                          " transducers on " + std::to_string(info.info.boards) +
                          " boards, but the array file has " + std::to_string(_layout.transducers) +
                          " on " + std::to_string(boards));
    lock.lock();
    _name = pool->name();
    _pool = std::move(pool);
    _lastHeard_s = _lastStatusAsked_s = _lastSubmit_s = base::steadySeconds();
    _ready = true;
    _counters.change(
        [&](DeviceReport& report)
        {
            report.state = DeviceState::READY;
            report.firmware = info.info.firmware();
        });
}

// With _mutex held. Goes by the control endpoint, so no field that waits in the pipe is before it; those that still come have
// smaller sequence numbers and never play. The worker repeats it until the device says that it is muted.
std::vector<UsbArrayDevice::Joint> UsbArrayDevice::muteLocked()
{
    std::vector<Joint> joints = settleAll(false);
    if (_pool == nullptr) return joints;
    _muteAwaited = nextSequence();
    submitMute();
    _pool->cancelSends();
    _wake.notify_all();
    return joints;
}

void UsbArrayDevice::silence()
{
    std::vector<Joint> joints;
    {
        std::lock_guard<std::mutex> lock(_mutex);
        joints = muteLocked();
    }
    for (const Joint& joint : joints)
        joint->giveUp();
}

bool UsbArrayDevice::identify(int board, bool light)
{
    Packet packet;
    packet.type = Type::IDENTIFY;
    packet.board = board < 0 ? protocol::kAllBoards : static_cast<std::uint16_t>(board);
    packet.light = light;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    std::lock_guard<std::mutex> lock(_mutex);
    return _ready && _pool->control(bytes);
}

// What the firmware said when it was greeted; nothing while it isn't there.
DriveAbility UsbArrayDevice::ability() const
{
    DriveAbility ability;
    std::lock_guard<std::mutex> lock(_mutex);
    ability.fieldsPerSecond = _info.info.fieldsPerSecond;
    return ability;
}

DeviceReport UsbArrayDevice::report() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    DeviceReport report = _counters.report();
    report.pending = _flying.size() + (_slotFull ? 1 : 0);
    return report;
}

std::string UsbArrayDevice::status() const
{
    const DeviceReport now = report();
    std::lock_guard<std::mutex> lock(_mutex);
    std::string text = _name + ": ";
    if (!_ready) return text + "not there; " + countersText(now);
    text += "firmware " + now.firmware + ", " + std::to_string(_layout.transducers) +
            " transducers, " + base::shortNumber(now.temperature_C) + " C, " + countersText(now);
    if ((_status.flags & protocol::WATCHDOG_FIRED) != 0)
        text += "; muted by its watchdog until the next field";
    if ((_status.flags & protocol::OVER_TEMPERATURE) != 0)
        text += "; muted until it has cooled down";
    return text;
}

std::vector<std::complex<float>> UsbArrayDevice::played() const
{
    std::vector<std::complex<float>> q;
    std::lock_guard<std::mutex> lock(_mutex);
    decode(_playing, q);
    return q;
}

} // namespace midair::device
