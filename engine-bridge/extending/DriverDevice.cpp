#include "engine-bridge/extending/DriverDevice.h"

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/extending/DriverThread.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

void checkLevels(const std::string& name, unsigned int phases, const std::vector<float>& amplitudes)
{
    const auto refuse = [&](const std::string& what)
    { throw device::DeviceError("device \"" + name + "\": " + what); };
    if (phases < 2 || phases > 256)
        refuse(fmt::format("its driver has {} phase levels; there must be 2 .. 256", phases));
    if (amplitudes.empty()) return;
    const bool rises =
        std::adjacent_find(amplitudes.begin(),
                           amplitudes.end(),
                           [](float a, float b) { return !(a < b); }) == amplitudes.end();
    if (amplitudes.size() < 2 || amplitudes.size() > 256 || !rises || amplitudes.front() != 0.0F ||
        amplitudes.back() != 1.0F)
        refuse("its driver's amplitudes must be 2 .. 256 that rise from 0 to 1");
}

} // namespace

DriverLevels::DriverLevels(const std::string& name,
                           unsigned int phaseLevels,
                           std::vector<float> amplitudes) :
    _phaseLevels(phaseLevels),
    _amplitudes(std::move(amplitudes))
{
    checkLevels(name, _phaseLevels, _amplitudes);
    for (const float amplitude : _amplitudes)
        _duties.push_back(
            static_cast<int>(std::lround(base::dutyLevel(static_cast<double>(amplitude)))));
}

unsigned char DriverLevels::phaseOf(std::uint8_t level) const
{
    return static_cast<unsigned char>((level * _phaseLevels + 128U) / 256U % _phaseLevels);
}

// A level of the driver's own is encoded as its own duty.
unsigned char DriverLevels::amplitudeOf(std::uint8_t duty) const
{
    if (_duties.empty()) return duty;
    const auto above = std::upper_bound(_duties.begin(), _duties.end(), static_cast<int>(duty));
    return static_cast<unsigned char>(above - _duties.begin() - 1);
}

void DriverLevels::round(const device::DriveSignal& signal,
                         std::vector<unsigned char>& phases,
                         std::vector<unsigned char>& amplitudes) const
{
    phases.resize(signal.phase.size());
    amplitudes.resize(signal.phase.size());
    for (std::size_t i = 0; i < phases.size(); ++i)
    {
        phases[i] = phaseOf(signal.phase[i]);
        amplitudes[i] = amplitudeOf(signal.duty[i]);
    }
}

std::vector<std::complex<float>> DriverLevels::activations(const device::DriveSignal& signal) const
{
    std::vector<std::complex<float>> q(signal.phase.size());
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        const unsigned char level = amplitudeOf(signal.duty[i]);
        const float amplitude =
            _amplitudes.empty() ? device::amplitudeLevels()[level] : _amplitudes[level];
        q[i] = std::polar(
            amplitude, static_cast<float>(base::kTwoPi * phaseOf(signal.phase[i]) / _phaseLevels));
    }
    return q;
}

DriverDevice::Opened DriverDevice::ask(const std::shared_ptr<ArrayDriver>& driver)
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
