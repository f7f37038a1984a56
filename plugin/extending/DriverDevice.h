#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"

#include <osgMidair/DeviceDriver>

#include <mutex>
#include <string>
#include <vector>

namespace osgMidair
{

/// Makes an ArrayDevice of an application's DeviceDriver: counts, rounds to the driver's levels,
/// and calls it from one thread at a time. GuardedDevice, which stands before it, keeps the limits.
class DriverDevice : public midair::device::ArrayDevice
{
public:
    /// What a driver says that it can play.
    struct Ability
    {
        unsigned int phaseLevels = 256;
        std::vector<float> amplitudes;
        double fieldsPerSecond = 0.0;
    };
    /// Asks \a driver, and throws what it throws.
    static Ability abilityOf(const DeviceDriver& driver);

    /// \a driver: open. Throws DeviceError, which names the device \a name, if its levels are out
    /// of their ranges.
    DriverDevice(const osg::ref_ptr<DeviceDriver>& driver,
                 const Ability& ability,
                 const std::string& name,
                 int transducers);
    ~DriverDevice() override;

    DriverDevice(const DriverDevice&) = delete;
    DriverDevice& operator=(const DriverDevice&) = delete;

    bool send(const midair::device::DriveSignal& signal) override;
    void silence() override;
    std::string status() const override;
    midair::device::DeviceReport report() const override;
    midair::device::DriveAbility ability() const override;
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>>
    wouldPlay(const midair::device::DriveSignal& signal) const override;

private:
    unsigned char phaseOf(std::uint8_t level) const;
    unsigned char amplitudeOf(std::uint8_t duty) const;
    bool isReady() const;
    void silenceLocked();

    const osg::ref_ptr<DeviceDriver> _driver;
    const std::string _name;
    const int _transducers;
    unsigned int _phaseLevels = 256;
    std::vector<float> _amplitudes; ///< of the driver; empty: those of DriveSignal
    std::vector<int> _duties;       ///< the duty level of each
    double _fieldsPerSecond = 0.0;
    mutable std::mutex _mutex; ///< guards the driver and the members below
    mutable midair::device::FieldCounters _counters;
    midair::device::DriveSignal _playing;
    std::vector<unsigned char> _phases;
    std::vector<unsigned char> _levels;
};

} // namespace osgMidair
