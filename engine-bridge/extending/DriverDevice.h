#pragma once

#include "device/ArrayDevice.h"
#include "engine-bridge/extending/DriverThread.h"

#include <string>
#include <vector>

namespace midair::bridge
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
    static Opened ask(const std::shared_ptr<ArrayDriver>& driver);

    /// Throws DeviceError, which names the device \a name, if the levels are out of their ranges.
    DriverDevice(Opened opened, const std::string& name, int transducers);

    DriverDevice(const DriverDevice&) = delete;
    DriverDevice& operator=(const DriverDevice&) = delete;

    bool send(const device::DriveSignal& signal) override { return _thread.send(signal); }
    void silence() override { _thread.silence(); }
    double confirmed_s() const override { return _thread.confirmed_s(); }
    std::string status() const override;
    device::DeviceReport report() const override { return _thread.report(); }
    device::DriveAbility ability() const override;
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const device::DriveSignal& signal) const override;

private:
    const std::string _name;
    const DriverLevels _levels;
    const double _fieldsPerSecond;
    DriverThread _thread;
};

} // namespace midair::bridge
