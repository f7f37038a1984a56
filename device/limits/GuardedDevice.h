#pragma once

#include "device/ArrayDevice.h"
#include "device/limits/DeviceClaim.h"

#include <condition_variable>
#include <mutex>
#include <thread>

namespace midair::device
{

class DeviceUri;

/// Holds the limits around a device: amplitude cap, ramp, thermal budget, mute. Nothing reaches the
/// device but through here.
///
/// Ramp and thermal budget need time to pass: then a thread sends the last field again with another
/// gain.
class GuardedDevice : public ArrayDevice
{
public:
    /// Throws DeviceError for limits that are out of range.
    /// \a claim is given back when the device is closed; may be null.
    GuardedDevice(std::unique_ptr<ArrayDevice> device,
                  const SafetyLimits& limits,
                  int transducers,
                  std::unique_ptr<DeviceClaim> claim = {});
    ~GuardedDevice() override; ///< takes ramp_s when something sounds

    GuardedDevice(const GuardedDevice&) = delete;
    GuardedDevice& operator=(const GuardedDevice&) = delete;

    bool send(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return _device->canStage(); }
    bool sendTogether(const DriveSignal& signal,
                      const std::shared_ptr<JointCommit>& joint) override;
    /// Refused where a limit needs time to pass, for no thread can change what a device plays by
    /// itself.
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    void setMuted(bool muted) override;
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< no sequences with a ramp, a thermal budget or a hold
    bool identify(int board, bool light) override { return _device->identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    bool limitsNeedTime() const;
    bool sendScaled(double now_s, const std::shared_ptr<JointCommit>& joint = nullptr);
    double capGain(const DriveSignal& signal) const; ///< of the amplitude cap alone
    double allowedGain(double now_s);
    void account(double now_s);
    void noteSilence();
    void run();

    const std::unique_ptr<DeviceClaim> _claim; ///< outlives the device
    const std::unique_ptr<ArrayDevice> _device;
    const SafetyLimits _limits;
    const int _transducers;
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    DriveSignal _wanted;
    DriveSignal _scaled;
    double _wantedPeak = 0;  ///< largest amplitude of _wanted
    double _wantedDrive = 0; ///< mean of its amplitudes squared
    double _ramp = 0;        ///< 0 .. 1
    double _meanDrive = 0;
    double _drive = 0; ///< of what sounds
    double _gain = 1;  ///< of what sounds
    double _accounted_s = 0;
    double _lastField_s = 0;
    bool _sounds = false;
    bool _muted = false;
    bool _closing = false;
    std::uint64_t _refused = 0;
    std::uint64_t _silences = 0;
    std::thread _thread;
};

/// Takes the limits out of the URI's parameters; the stricter of the two counts.
SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits);

/// The stricter of two caps of pressure; 0 is none.
double stricterPressure(double a_Pa, double b_Pa);

/// \a signal with all amplitudes times \a gain in [0, 1], rounded down to duty levels, so that no
/// limit is exceeded.
void scaleDuties(const DriveSignal& signal, double gain, DriveSignal& scaled);

} // namespace midair::device
