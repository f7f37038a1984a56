#include "engine-bridge/extending/DriverDevice.h"

#include "device/FieldCounters.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

DriverDevice::Opened DriverDevice::ask(const std::shared_ptr<ArrayDriver>& driver)
{
    return {{driver, driver->isReady(), driver->getStatus()},
            driver->phaseLevels(),
            driver->amplitudes(),
            driver->fieldsPerSecond()};
}

DriverDevice::DriverDevice(Opened opened, const std::string& name, int transducers) :
    _name(name),
    _levels(name, opened.phaseLevels, std::move(opened.amplitudes)),
    _fieldsPerSecond(std::max(0.0, opened.fieldsPerSecond)),
    _thread(std::move(opened.driver), name, _levels, transducers)
{
}

// What the driver said of itself before a loss is no longer true.
std::string DriverDevice::status() const
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

device::DriveAbility DriverDevice::ability() const
{
    device::DriveAbility ability;
    ability.phaseLevels = static_cast<int>(_levels.phaseLevels());
    ability.amplitudes = _levels.amplitudes();
    ability.fieldsPerSecond = _fieldsPerSecond;
    return ability;
}

std::vector<std::complex<float>> DriverDevice::played() const
{
    return _levels.activations(_thread.playing());
}

std::vector<std::complex<float>> DriverDevice::wouldPlay(const device::DriveSignal& signal) const
{
    return _levels.activations(signal);
}

} // namespace midair::bridge
