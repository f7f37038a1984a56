#include "engine-bridge/extending/ArrayDriver.h"

#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/extending/DriverThread.h"
#include "haptics/base/ThrownBy.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Makes an ArrayDevice of an application's driver, which is called on a thread of its own.
/// GuardedDevice, which stands before it, keeps the limits.
class DriverDevice : public device::ArrayDevice
{
public:
    /// What a driver says when it has been opened.
    struct Opened
    {
        DriverThread::Opened driver;
        unsigned int phaseLevels = 256;
        std::vector<float> amplitudes;
        double fieldsPerSecond = 0.0;
    };
    /// Asks \a driver, and throws what it throws.
    static Opened ask(const std::shared_ptr<ArrayDriver>& driver)
    {
        return {{driver, driver->isReady(), driver->getStatus()},
                driver->getPhaseLevels(),
                driver->getAmplitudes(),
                driver->getFieldsPerSecond()};
    }

    /// Throws DeviceError, which names the device \a name, if the levels are out of their ranges.
    DriverDevice(Opened opened, const std::string& name, int transducers) :
        _name(name),
        _levels(name, opened.phaseLevels, std::move(opened.amplitudes)),
        _fieldsPerSecond(std::max(0.0, opened.fieldsPerSecond)),
        _thread(std::move(opened.driver), name, _levels, transducers)
    {
    }

    bool send(const device::DriveSignal& signal) override { return _thread.send(signal); }
    void silence() override { _thread.silence(); }
    double confirmed_s() const override { return _thread.confirmed_s(); }
    // What the driver said of itself before a loss is no longer true.
    std::string status() const override
    {
        using device::DeviceState;
        const device::DeviceReport report = _thread.report();
        const bool isLost = report.state == DeviceState::LOST;
        const std::string own = isLost                                ? "lost"
                                : report.state < DeviceState::HANGING ? _thread.status()
                                : report.unsilenced.empty()           ? "hangs"
                                                                      : "not silenced";
        return _name + (_name.back() == ':' ? " " : ": ") + (own.empty() ? "" : own + ": ") +
               device::countersText(report) +
               (isLost && !report.unsilenced.empty() ? "; " + report.unsilenced : "");
    }
    device::DeviceReport report() const override { return _thread.report(); }
    device::DriveAbility ability() const override
    {
        device::DriveAbility ability;
        ability.phaseLevels = static_cast<int>(_levels.phaseLevels());
        ability.amplitudes = _levels.amplitudes();
        ability.fieldsPerSecond = _fieldsPerSecond;
        return ability;
    }
    std::vector<std::complex<float>> played() const override
    {
        return _levels.activations(_thread.playing());
    }
    std::vector<std::complex<float>> wouldPlay(const device::DriveSignal& signal) const override
    {
        return _levels.activations(signal);
    }

private:
    const std::string _name;
    const DriverLevels _levels;
    const double _fieldsPerSecond;
    DriverThread _thread;
};

/// What a driver is to open.
struct Asked
{
    std::string path;
    std::map<std::string, std::string> options;
    ArrayDriver::Layout layout;
};

/// Silences a driver that is let go before it has played. Returns with what a reason goes on if
/// that failed.
std::string silenced(ArrayDriver& driver)
{
    const std::string thrown = base::thrownBy([&] { driver.silence(); });
    if (thrown.empty()) return {};
    return "; its silence() has thrown " + thrown + ", too, so the array may play";
}

/// Returns what the open driver says; null, with the reason in \a why, if it can't be made or
/// opened. It is an application's code: what it throws is a reason.
std::optional<DriverDevice::Opened>
openDriver(const ArrayDriverFactory& make, const Asked& asked, std::string& why)
{
    std::shared_ptr<ArrayDriver> driver;
    bool isOpen = false;
    DriverDevice::Opened opened;
    const std::string thrown = base::thrownBy(
        [&]
        {
            driver = make();
            isOpen = driver && driver->open(asked.path, asked.options, asked.layout, why);
            if (isOpen) opened = DriverDevice::ask(driver);
        });
    if (thrown.empty() && isOpen) return opened;
    const std::string unsilenced = isOpen ? silenced(*driver) : std::string();
    if (!thrown.empty())
        why = "its driver has thrown " + thrown + unsilenced;
    else if (!driver)
        why = "its driver could not be made";
    else if (why.empty())
        why = "its driver could not open it";
    return std::nullopt;
}

} // namespace

bool registerDriver(const std::string& scheme, ArrayDriverFactory make, std::string& error)
{
    if (!make)
    {
        error = "the scheme \"" + scheme + "\" has nothing that makes its driver";
        return false;
    }
    const auto open = [make = std::move(make)](device::DeviceUri& uri,
                                               const device::DeviceLayout& layout)
        -> std::unique_ptr<device::ArrayDevice>
    {
        const std::string name = uri.scheme() + ":" + uri.path();
        if (DriverThread::isLeftBehind(name))
            throw uri.error("the driver that had it was closed and hasn't returned yet");
        std::string why;
        const ArrayDriver::Layout levels{static_cast<unsigned int>(layout.transducers),
                                         layout.board};
        auto opened = openDriver(make, {uri.path(), uri.takeRest(), levels}, why);
        if (!opened) throw uri.error(why);
        const std::shared_ptr<ArrayDriver> driver = opened->driver.driver;
        try
        {
            return std::make_unique<DriverDevice>(std::move(*opened), name, layout.transducers);
        }
        catch (const device::DeviceError& error)
        {
            throw device::DeviceError(error.what() + silenced(*driver));
        }
    };
    return device::registerScheme({scheme, open}, error);
}

} // namespace midair::bridge
