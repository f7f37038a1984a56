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

/// When a driver's silence() is to be called: as soon as it is wanted, again and again while it
/// fails, and seldom while the driver is lost. Has no lock: the owner guards it. All times are
/// those of steadySeconds().
class DueSilence
{
public:
    static constexpr double kSoon_s = 0.1; ///< pause after a failure
    /// The pause from failure kSoonTries on, and while the driver is lost.
    static constexpr double kLater_s = 1.0;
    static constexpr int kSoonTries = 10;
    static constexpr int kLastTries = 5; ///< failures after which a driver is closed all the same

    void want() { _isWanted = true; }
    /// The next one waits for no pause, as the driver was just lost, is back or is closed.
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
    bool isGivenUp() const { return _failures >= kLastTries; } ///< for a driver that is closed

    /// To be called before silence(), so that one that is wanted meanwhile is another one.
    void begin() { _isWanted = false; }
    /// silence() has returned. \a isSeldom: the driver is lost, and the next one has time.
    void succeed(double now_s, bool isSeldom)
    {
        _failures = 0;
        _from_s = isSeldom ? now_s + kLater_s : 0.0;
    }
    /// silence() has thrown: it is wanted again.
    void fail(double now_s, bool isSeldom)
    {
        _isWanted = true;
        _from_s = now_s + (isSeldom || ++_failures >= kSoonTries ? kLater_s : kSoon_s);
    }

private:
    bool _isWanted = false;
    double _from_s = 0.0; ///< not before
    int _failures = 0;    ///< in a row, while the driver isn't lost
};

/// The phases and amplitudes that an application's driver can play, and fields in them.
class DriverLevels
{
public:
    /// \a amplitudes empty: those of DriveSignal. Throws DeviceError, which names the device
    /// \a name, if they are out of their ranges.
    DriverLevels(const std::string& name, unsigned int phaseLevels, std::vector<float> amplitudes);

    unsigned int phaseLevels() const { return _phaseLevels; }
    const std::vector<float>& amplitudes() const { return _amplitudes; }

    /// Rounds \a signal to the driver's levels: amplitudes down, so that no cap is exceeded.
    void round(const device::DriveSignal& signal,
               std::vector<unsigned char>& phases,
               std::vector<unsigned char>& amplitudes) const;

    /// The same as activations.
    std::vector<std::complex<float>> activations(const device::DriveSignal& signal) const;

private:
    unsigned char phaseOf(std::uint8_t level) const;
    unsigned char amplitudeOf(std::uint8_t duty) const;

    unsigned int _phaseLevels;
    std::vector<float> _amplitudes;
    std::vector<int> _duties; ///< the duty level of each
};

/// An array of an application's driver, which is called on a thread of its own, so that nobody
/// waits for its code: while a call runs, the newest field waits, and a silence is due before it.
/// GuardedDevice, which stands before it, keeps the limits.
///
/// All members may be called from any thread. None waits for the driver but the destructor.
class DriverDevice : public device::ArrayDevice
{
public:
    /// A call that has not returned after this time hangs, which the report says.
    static constexpr double kHangs_s = 1.0;
    /// The longest time that the destructor waits for the driver.
    static constexpr double kFarewell_s = 3.0;

    /// What a driver says when it has been opened.
    struct Opened
    {
        std::shared_ptr<ArrayDriver> driver;
        bool isReady = true;
        std::string status;
        unsigned int phaseLevels = 256;
        std::vector<float> amplitudes;
        double fieldsPerSecond = 0.0;
    };
    /// Asks \a driver, and throws what it throws.
    static Opened ask(const std::shared_ptr<ArrayDriver>& driver);

    /// Throws DeviceError, which names the device \a name, if the levels are out of their ranges.
    DriverDevice(Opened opened, const std::string& name, int transducers);
    /// Has the driver silenced and let go. A driver that hangs is left to the thread, which does
    /// both once the call has returned; the log says so.
    ~DriverDevice() override;

    DriverDevice(const DriverDevice&) = delete;
    DriverDevice& operator=(const DriverDevice&) = delete;

    /// Has \a signal played as soon as the driver has returned, in place of one that still waits.
    /// Returns false if it is for another number of transducers or the driver isn't ready.
    bool send(const device::DriveSignal& signal) override;
    void silence() override;
    double confirmed_s() const override; ///< what the driver has returned from
    device::DeviceReport report() const override;
    std::string status() const override;
    device::DriveAbility ability() const override;
    /// The newest field that the driver has taken; off after a silence.
    std::vector<std::complex<float>> played() const override;
    std::vector<std::complex<float>> wouldPlay(const device::DriveSignal& signal) const override;

    /// Returns true while a driver of the device \a name, which has been closed, still hangs.
    static bool isLeftBehind(const std::string& name);

private:
    struct Shared;

    const double _fieldsPerSecond;
    std::shared_ptr<Shared> _shared; ///< outlives this object in a thread that is left behind
    std::thread _thread;
};

} // namespace midair::bridge
