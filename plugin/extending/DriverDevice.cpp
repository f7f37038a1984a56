#include "plugin/extending/DriverDevice.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

using midair::device::DeviceError;
using midair::device::DeviceReport;
using midair::device::DriveSignal;

namespace
{

/// Calls \a call; an exception is a fault in \a counters, and gives \a otherwise.
template<typename Call, typename Result>
Result guarded(midair::device::FieldCounters& counters, const Call& call, Result otherwise)
{
    try
    {
        return call();
    }
    catch (const std::exception& error)
    {
        counters.countFault(std::string("the driver threw: ") + error.what());
    }
    catch (...)
    {
        counters.countFault("the driver threw what is no std::exception");
    }
    return otherwise;
}

void checkLevels(const std::string& name, unsigned int phases, const std::vector<float>& amplitudes)
{
    const auto refuse = [&](const std::string& what)
    { throw DeviceError("device \"" + name + "\": " + what); };
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

DriverDevice::Ability DriverDevice::abilityOf(const DeviceDriver& driver)
{
    return {driver.getPhaseLevels(), driver.getAmplitudes(), driver.getFieldsPerSecond()};
}

DriverDevice::DriverDevice(const osg::ref_ptr<DeviceDriver>& driver,
                           const Ability& ability,
                           const std::string& name,
                           int transducers) :
    _driver(driver),
    _name(name),
    _transducers(transducers),
    _phaseLevels(ability.phaseLevels),
    _amplitudes(ability.amplitudes),
    _fieldsPerSecond(std::max(0.0, ability.fieldsPerSecond)),
    _playing(midair::device::silentSignal(transducers)),
    _phases(static_cast<std::size_t>(transducers)),
    _levels(static_cast<std::size_t>(transducers))
{
    checkLevels(name, _phaseLevels, _amplitudes);
    for (const float amplitude : _amplitudes)
        _duties.push_back(
            static_cast<int>(std::lround(midair::base::dutyLevel(static_cast<double>(amplitude)))));
}

DriverDevice::~DriverDevice()
{
    const std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked();
}

unsigned char DriverDevice::phaseOf(std::uint8_t level) const
{
    return static_cast<unsigned char>((level * _phaseLevels + 128U) / 256U % _phaseLevels);
}

// Down, so that no cap is exceeded; a level of the driver's own is encoded as its own duty.
unsigned char DriverDevice::amplitudeOf(std::uint8_t duty) const
{
    if (_duties.empty()) return duty;
    const auto above = std::upper_bound(_duties.begin(), _duties.end(), static_cast<int>(duty));
    return static_cast<unsigned char>(above - _duties.begin() - 1);
}

bool DriverDevice::isReady() const
{
    return guarded(
        _counters, [this] { return _driver->isReady(); }, false);
}

bool DriverDevice::send(const DriveSignal& signal)
{
    const double start_s = midair::base::steadySeconds();
    const std::lock_guard<std::mutex> lock(_mutex);
    if (!signal.fits(_transducers) || !isReady())
    {
        _counters.countRefused();
        return false;
    }
    for (std::size_t i = 0; i < _phases.size(); ++i)
    {
        _phases[i] = phaseOf(signal.phase[i]);
        _levels[i] = amplitudeOf(signal.duty[i]);
    }
    const std::uint64_t faults = _counters.report().faults;
    if (guarded(
            _counters, [this] { return _driver->play(_phases.data(), _levels.data()); }, false))
    {
        _playing = signal;
        _counters.countPlayed(start_s);
        return true;
    }
    if (_counters.report().faults == faults)
        _counters.change([](DeviceReport& report) { report.message = "the driver took no field"; });
    _counters.countRefused();
    return false;
}

void DriverDevice::silenceLocked()
{
    _playing = midair::device::silentSignal(_transducers);
    guarded(
        _counters,
        [this]
        {
            _driver->silence();
            return true;
        },
        false);
}

void DriverDevice::silence()
{
    const std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked();
}

std::string DriverDevice::status() const
{
    const DeviceReport now = report();
    const std::lock_guard<std::mutex> lock(_mutex);
    const std::string own = guarded(
        _counters, [this] { return _driver->getStatus(); }, std::string());
    return _name + (_name.back() == ':' ? " " : ": ") + (own.empty() ? "" : own + ": ") +
           midair::device::countersText(now);
}

DeviceReport DriverDevice::report() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    const bool ready = isReady();
    DeviceReport report = _counters.report();
    if (!ready) report.state = midair::device::DeviceState::LOST;
    return report;
}

midair::device::DriveAbility DriverDevice::ability() const
{
    midair::device::DriveAbility ability;
    ability.phaseLevels = static_cast<int>(_phaseLevels);
    ability.amplitudes = _amplitudes;
    ability.fieldsPerSecond = _fieldsPerSecond;
    return ability;
}

std::vector<std::complex<float>> DriverDevice::played() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return wouldPlay(_playing);
}

std::vector<std::complex<float>> DriverDevice::wouldPlay(const DriveSignal& signal) const
{
    std::vector<std::complex<float>> q(signal.phase.size());
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        const unsigned char level = amplitudeOf(signal.duty[i]);
        const float amplitude =
            _amplitudes.empty() ? midair::device::amplitudeLevels()[level] : _amplitudes[level];
        q[i] = std::polar(
            amplitude,
            static_cast<float>(midair::base::kTwoPi * phaseOf(signal.phase[i]) / _phaseLevels));
    }
    return q;
}

} // namespace osgMidair
