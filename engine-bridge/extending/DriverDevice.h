#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveSignal.h"
#include "engine-bridge/extending/ArrayDriver.h"

#include <algorithm>
#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Schedules a driver's silence(): at once when requested, repeatedly while it fails, and rarely
/// while the driver is lost. Has no lock: the owner guards it. All times are those of
/// steadySeconds().
class DueSilence
{
public:
    static constexpr double kSoon_s = 0.1; ///< pause after a failure
    /// Pause after failure kSoonTries, and while the driver is lost.
    static constexpr double kLater_s = 1.0;
    static constexpr int kSoonTries = 10;
    static constexpr int kLastTries = 5; ///< failures after which a driver is closed anyway

    void want() { _isWanted = true; }
    /// Skips the pause, because the driver was just lost, is back or is closed.
    void wantNow()
    {
        _isWanted = true;
        _from_s = 0.0;
        _failures = 0;
    }

    bool isWanted() const { return _isWanted; }
    bool isDue(double now_s) const { return _isWanted && now_s >= _from_s; }
    /// Time until it is due, >= 0; infinite if none is wanted.
    double rest_s(double now_s) const
    {
        return _isWanted ? std::max(0.0, _from_s - now_s) : std::numeric_limits<double>::infinity();
    }
    bool isGivenUp() const { return _failures >= kLastTries; } ///< for a driver being closed

    /// To be called before silence(), so that a request during the call counts as a new one.
    void begin() { _isWanted = false; }
    /// silence() has returned. \a isSeldom: the driver is lost, so the next call can wait.
    void succeed(double now_s, bool isSeldom)
    {
        _failures = 0;
        _from_s = isSeldom ? now_s + kLater_s : 0.0;
    }
    /// silence() has thrown: it has to be repeated.
    void fail(double now_s, bool isSeldom)
    {
        _isWanted = true;
        _from_s = now_s + (isSeldom || ++_failures >= kSoonTries ? kLater_s : kSoon_s);
    }

private:
    bool _isWanted = false;
    double _from_s = 0.0; ///< not before
    int _failures = 0;    ///< consecutive, while the driver isn't lost
};

/// Phases and amplitudes that an application's driver can play, and the encoding of fields in them.
class DriverLevels
{
public:
    /// \a amplitudes empty: those of DriveSignal. Throws DeviceError, which names the device \a
    /// name, if values are out of range.
    DriverLevels(const std::string& name, unsigned int phaseLevels, std::vector<float> amplitudes);

    unsigned int phaseLevels() const { return _phaseLevels; }
    const std::vector<float>& amplitudes() const { return _amplitudes; }

    /// Rounds \a signal to the driver's levels: amplitudes down, so that no cap is exceeded.
    void round(const device::DriveSignal& signal,
               std::vector<unsigned char>& phases,
               std::vector<unsigned char>& amplitudes) const;

    /// Returns the same as activations.
    std::vector<std::complex<float>> activations(const device::DriveSignal& signal) const;

private:
    unsigned char phaseOf(std::uint8_t level) const;
    unsigned char amplitudeOf(std::uint8_t duty) const;

    unsigned int _phaseLevels;
    std::vector<float> _amplitudes;
    std::vector<int> _duties; ///< the duty level of each
};

/// An array of an application's driver, which is called on a separate thread, so that nothing waits
/// for its code: while a call runs, the newest field waits, and a silence comes before it. A
/// GuardedDevice in front of it enforces the limits.
///
/// All members may be called from any thread. Only the destructor waits for the driver.
class DriverDevice : public device::ArrayDevice
{
public:
    /// A call that takes longer hangs, which is reported.
    static constexpr double kHangs_s = 1.0;
    /// The longest time that the destructor waits for the driver.
    static constexpr double kFarewell_s = 3.0;

    /// Properties of an opened driver.
    struct Opened
    {
        std::shared_ptr<ArrayDriver> driver;
        bool isReady = true;
        std::string status;
        unsigned int phaseLevels = 256;
        std::vector<float> amplitudes;
        double fieldsPerSecond = 0.0;
    };
    /// Queries \a driver, and passes on its exceptions.
    static Opened ask(const std::shared_ptr<ArrayDriver>& driver);

    /// Throws DeviceError, which names the device \a name, if the levels are out of their ranges.
    DriverDevice(Opened opened, const std::string& name, int transducers);
    /// Has the driver silenced and released. A hanging driver is left to the thread, which does
    /// both when the call returns; this is logged.
    ~DriverDevice() override;

    DriverDevice(const DriverDevice&) = delete;
    DriverDevice& operator=(const DriverDevice&) = delete;

    /// Has \a signal played when the driver returns, replacing a waiting one. Returns false for
    /// another number of transducers, or if the driver isn't ready.
    bool send(const device::DriveSignal& signal) override;
    void silence() override;
    double confirmed_s() const override; ///< time of the last call that returned
    device::DeviceReport report() const override;
    std::string status() const override;
    device::DriveAbility ability() const override;
    /// The newest field that the driver has accepted; off after a silence.
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const device::DriveSignal& signal) const override;

    /// Returns true while a driver of the closed device \a name still hangs.
    static bool isLeftBehind(const std::string& name);

private:
    struct Shared;

    const double _fieldsPerSecond;
    std::shared_ptr<Shared> _shared; ///< outlives this object if its thread hangs
    std::thread _thread;
};

} // namespace midair::bridge
