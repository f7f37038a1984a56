#pragma once

#include "device/ArrayDevice.h"
#include "device/limits/DeviceClaim.h"
#include "device/limits/QuietWatch.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace midair::device
{

class DeviceUri;

/// Wraps a device and enforces its limits: amplitude cap, ramp, thermal budget, hold, mute.
/// Everything that reaches the device goes through here.
///
/// With a ramp or thermal budget a thread resends the last field with another gain as time passes.
/// It is also the one watchdog of all devices: without a sign of life for the time of the hold it
/// silences the device, whatever is sent, and what was asked to become quieter and isn't confirmed
/// in time (QuietWatch) it silences, again and again until that is confirmed.
class GuardedDevice : public ArrayDevice
{
public:
    /// Throws DeviceError for limits that are out of range. \a claim is released after the device
    /// is closed; may be null.
    GuardedDevice(std::unique_ptr<ArrayDevice> device,
                  const SafetyLimits& limits,
                  int transducers,
                  std::unique_ptr<DeviceClaim> claim = {});
    ~GuardedDevice() override; ///< takes up to ramp_s if a field is played

    GuardedDevice(const GuardedDevice&) = delete;
    GuardedDevice& operator=(const GuardedDevice&) = delete;

    bool send(const DriveSignal& signal) override
    {
        keepAlive();
        return sendUnled(signal);
    }
    bool sendUnled(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return _device->canStage(); }
    /// No sign of life.
    bool sendTogether(const DriveSignal& signal,
                      const std::shared_ptr<JointCommit>& joint) override;
    /// Refuses all sequences with a ramp or thermal budget, since the gain of a sequence can't be
    /// changed while the device plays it. After the hold it is silenced as a field is.
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    void setMuted(bool muted) override;
    bool setAmplitudeCap(double amplitude) override;
    void noteSign(double at_s) override { _lastSign_s = at_s; }
    bool isHoldOver() const override;
    double confirmed_s() const override { return _device->confirmed_s(); }
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< no sequences with a ramp or a thermal budget
    bool identify(int board, bool light) override { return _device->identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<PlayedField> playedSince(double from_s) const override
    {
        return _device->playedSince(from_s);
    }
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    bool gainNeedsTime() const { return _limits.ramp_s > 0 || _limits.meanDrive < 1; }
    bool sendScaled(double now_s, const std::shared_ptr<JointCommit>& joint = nullptr);
    double capGain(const DriveSignal& signal) const; ///< for the amplitude cap only
    double allowedGain(double now_s);
    void account(double now_s);
    void silenceLocked();
    void noteSilence();
    void ask(const std::optional<Loudness>& level, double asked_s, bool taken = true);
    void settle() const;
    void watchHold();
    void watchQuieting();
    double nextDue_s() const; ///< when run() has something to do
    void run();

    const std::unique_ptr<DeviceClaim> _claim; ///< outlives the device
    const std::unique_ptr<ArrayDevice> _device;
    /// The lower of the cap that it was opened with and that of setAmplitudeCap().
    double maxAmplitude() const { return std::min(_limits.maxAmplitude, _cap.load()); }

    const SafetyLimits _limits;
    std::atomic<double> _cap{1.0}; ///< of setAmplitudeCap(); written under _mutex
    const int _transducers;
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    DriveSignal _wanted;
    DriveSignal _scaled;
    double _wantedPeak = 0;          ///< largest amplitude of _wanted
    double _wantedDrive = 0;         ///< mean of its amplitudes squared
    double _ramp = 0;                ///< 0 .. 1; gain of the ramp
    double _meanDrive = 0;           ///< mean over time of _drive
    double _drive = 0;               ///< mean amplitude squared of what is played
    double _gain = 1;                ///< gain of what is played
    double _accounted_s = 0;         ///< time of _meanDrive
    std::atomic<double> _lastSign_s; ///< of life
    bool _isAbandoned = false;       ///< the hold has silenced it, and no field came since
    mutable QuietWatch _quiet;       ///< of what was handed to the device
    double _patience_s = QuietWatch::kConfirm_s;
    mutable std::string _quieted;    ///< DeviceReport::quieted
    mutable std::string _unsilenced; ///< DeviceReport::unsilenced, as far as seen here
    bool _sounds = false;
    bool _inTurn = false; ///< what sounds is a sequence, which can't be lowered while it plays
    bool _muted = false;
    bool _closing = false;
    std::uint64_t _refused = 0;
    std::uint64_t _silences = 0;
    std::uint64_t _faults = 0;                                  ///< of what wasn't confirmed
    double _wakeAt_s = std::numeric_limits<double>::infinity(); ///< until then run() sleeps
    std::thread _thread; ///< from the start with limits that need time, else when it is needed
};

/// Throws DeviceError for limits that are out of range.
void checkLimits(const SafetyLimits& limits);

/// Takes the limits from the URI's parameters and combines them with \a limits, see SafetyLimits.
SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits);

/// The lower of two pressure caps; 0 means none.
double stricterPressure(double a_Pa, double b_Pa);

} // namespace midair::device
