#include "plugin/extending/DriverDevice.h"

#include "device/FieldCounters.h"

#include <algorithm>
#include <utility>

namespace osgMidair
{

DriverDevice::Opened DriverDevice::ask(const osg::ref_ptr<DeviceDriver>& driver)
{
    return {{driver, driver->isReady(), driver->getStatus()},
            driver->getPhaseLevels(),
            driver->getAmplitudes(),
            driver->getFieldsPerSecond()};
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
    using midair::device::DeviceState;
    const midair::device::DeviceReport report = _thread.report();
    const bool isLost = report.state == DeviceState::LOST;
    const std::string own = isLost                                ? "lost"
                            : report.state < DeviceState::HANGING ? _thread.status()
                            : report.unsilenced.empty()           ? "hangs"
                                                                  : "not silenced";
    return _name + (_name.back() == ':' ? " " : ": ") + (own.empty() ? "" : own + ": ") +
           midair::device::countersText(report) +
           (isLost && !report.unsilenced.empty() ? "; " + report.unsilenced : "");
}

midair::device::DriveAbility DriverDevice::ability() const
{
    midair::device::DriveAbility ability;
    ability.phaseLevels = static_cast<int>(_levels.phaseLevels());
    ability.amplitudes = _levels.amplitudes();
    ability.fieldsPerSecond = _fieldsPerSecond;
    return ability;
}

std::vector<std::complex<float>> DriverDevice::played() const
{
    return _levels.activations(_thread.playing());
}

std::vector<std::complex<float>>
DriverDevice::wouldPlay(const midair::device::DriveSignal& signal) const
{
    return _levels.activations(signal);
}

} // namespace osgMidair
