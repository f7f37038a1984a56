#include "device/usb/UsbArrayDevice.h"

#include "device/DeviceLog.h"
#include "device/DeviceUri.h"
#include "haptics/base/threads/SteadyClock.h"

#include <charconv>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

constexpr double kFarewell_s = 0.2;
constexpr double kReconnect_s = 0.25;

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
    _connection(layout, "usb:" + options.address.serial)
{
    try
    {
        connect(false);
    }
    catch (const DeviceError& error)
    {
        if (!options.wait) throw;
        _connection.counters().countFault(error.what());
        deviceLog().warn("{}; waiting for it", error.what());
    }
    _thread = std::thread([this] { run(); });
}

UsbArrayDevice::~UsbArrayDevice()
{
    _connection.close(kFarewell_s);
    {
        const base::Lock lock(_mutex);
        _closing = true;
    }
    _wake.notifyAll();
    _thread.join();
}

void UsbArrayDevice::connect(bool isBack)
{
    _connection.begin();
    try
    {
        auto link = std::make_unique<UsbLink>(_options.address, _layout, _connection);
        _fieldsPerSecond = link->info().fieldsPerSecond;
        _connection.attach(std::move(link), isBack);
        _connected = true;
    }
    catch (const DeviceError&)
    {
        _connection.detach();
        throw;
    }
}

void UsbArrayDevice::giveUp(const std::string& why)
{
    _connected = false;
    const std::unique_ptr<UsbLink> link = _connection.detach(why); // destroyed at the end
    deviceLog().error("{}: {}; silent until it is back", _connection.name(), why);
}

bool UsbArrayDevice::isClosedWithin(double atMost_s)
{
    const double until_s = base::steadySeconds() + atMost_s;
    base::Lock lock(_mutex);
    while (!_closing && _wake.waitUntil_s(lock, until_s))
    {
    }
    return _closing;
}

void UsbArrayDevice::run()
{
    std::string refusal;
    for (;;)
    {
        if (_connected)
        {
            const std::string why = _connection.work();
            if (why.empty()) return; // closed
            giveUp(why);
        }
        if (isClosedWithin(kReconnect_s)) return;
        try
        {
            connect(true);
            refusal.clear();
            deviceLog().info("{}: back, silent until the next field", _connection.name());
        }
        catch (const DeviceError& error)
        {
            if (refusal != error.what()) // logs each reason once, not every 0.25 s
                deviceLog().warn("{}", error.what());
            refusal = error.what();
        }
    }
}

// fieldsPerSecond is the firmware's value at the last greeting; 0 before.
DriveAbility UsbArrayDevice::ability() const
{
    DriveAbility ability;
    ability.fieldsPerSecond = _fieldsPerSecond;
    return ability;
}

std::string UsbArrayDevice::status() const
{
    const DeviceReport now = report();
    const std::uint16_t flags = _connection.flags();
    std::string text = _connection.name() + ": ";
    if (now.state == DeviceState::LOST) return text + "not there; " + countersText(now);
    text += fmt::format("firmware {}, {} transducers, {:g} C, {}",
                        now.firmware,
                        _layout.transducers,
                        now.temperature_C,
                        countersText(now));
    if ((flags & protocol::WATCHDOG_FIRED) != 0)
        text += "; muted by its watchdog until the next field";
    if ((flags & protocol::OVER_TEMPERATURE) != 0) text += "; muted until it has cooled down";
    return text;
}

} // namespace midair::device
