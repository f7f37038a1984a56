#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveSignal.h"
#include "device/limits/DeviceClaim.h"
#include "device/limits/Lead.h"
#include "device/limits/QuietWatch.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace midair::device
{

/// The requested field of a device, and the amplitude that SafetyLimits allow over time: amplitude
/// cap, ramp, thermal budget.
///
/// Has no lock: the owner guards it. Times are of any one clock.
class LimitedDrive
{
public:
    LimitedDrive(const SafetyLimits& limits, double now_s);

    /// Ramp or budget: the gain changes while a field is held.
    bool needsTime() const { return _limits.ramp_s > 0 || _limits.meanDrive < 1; }
    /// Longest time between two updates, s.
    double step_s() const;

    void want(const DriveSignal& signal);
    /// Returns the allowed gain of the requested field, with its peak at most \a cap.
    double allowed(double cap, double now_s);
    /// Returns the requested field with that gain; valid until the next call.
    const DriveSignal& lowered(double cap, double now_s);
    /// Reports whether the device has taken the last lowered(); otherwise it plays on.
    void noteSent(bool taken);
    /// Reports that a sequence plays, with its loudest field lowered by \a gain. With ramp or
    /// budget no sequences are sent.
    void noteSequence(double gain) { _gain = gain; }
    void noteSilence(double now_s);

    double gain() const { return _gain; } ///< of the present output
    bool isRampedUp() const { return _limits.ramp_s > 0 && _ramp > 0; }
    /// Advances the ramp by \a passed_s, upwards or down.
    void passRamp(double passed_s, bool upwards);
    /// Returns true if the gain changes enough for a new field (half a duty level), or arrives.
    bool isDue(double cap, double now_s);

private:
    double mostGain(double cap) const; ///< of the requested field, without ramp and budget
    void account(double now_s);

    const SafetyLimits _limits;
    DriveSignal _wanted;
    DriveSignal _lowered;
    double _wantedPeak = 0;  ///< largest amplitude of _wanted
    double _wantedDrive = 0; ///< mean of its amplitudes squared
    double _ramp = 0;        ///< 0 .. 1; gain of the ramp
    double _gain = 1;        ///< of the present output
    double _drive = 0;       ///< mean squared amplitude of the present output
    double _meanDrive = 0;   ///< mean of that over time
    double _accounted_s;     ///< time of _meanDrive
};

/// The largest amplitude of \a signal.
double peakAmplitude(const DriveSignal& signal);
/// Returns the gain that lowers \a signal to a peak of \a cap; 1 if it is not louder.
double capGain(const DriveSignal& signal, double cap);

class DeviceUri;

/// Wraps a device and enforces its limits: amplitude cap, ramp, thermal budget, hold, mute. All
/// output passes through it. Its Lead holds the application's requests.
///
/// With a ramp or thermal budget, a thread resends the last field with changing gain. It is also
/// the single watchdog of all devices: without a sign of life during the hold time it silences the
/// device, whatever is sent, and it silences a device that doesn't confirm a quieter field in time
/// (QuietWatch), repeatedly until the silence is confirmed.
class GuardedDevice : public ArrayDevice
{
public:
    /// Throws DeviceError for limits out of range. \a claim is released after the device is closed;
    /// may be null. \a clock must outlive it, and is the clock of the device's confirmed_s().
    GuardedDevice(std::unique_ptr<ArrayDevice> device,
                  const SafetyLimits& limits,
                  int transducers,
                  std::unique_ptr<DeviceClaim> claim = {},
                  const base::Clock& clock = base::steadyClock());
    ~GuardedDevice() override; ///< takes up to ramp_s if a field plays

    GuardedDevice(const GuardedDevice&) = delete;
    GuardedDevice& operator=(const GuardedDevice&) = delete;

    bool send(const DriveSignal& signal) override
    {
        keepAlive();
        return sendUnled(signal);
    }
    bool sendUnled(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return _device->canStage(); }
    /// Not a sign of life.
    bool sendTogether(const DriveSignal& signal,
                      const std::shared_ptr<JointCommit>& joint) override;
    /// Refuses all sequences with a ramp or thermal budget, because the gain of a playing sequence
    /// can't be changed. The hold silences sequences like fields.
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    void setMuted(bool muted) override;
    bool setAmplitudeCap(double amplitude) override;
    void keepAlive() override { lead()->keepAlive(); }
    void follow(const std::shared_ptr<Lead>& lead) override;
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
    /// Last output of the device.
    struct Sounding
    {
        bool isAny = false;
        bool inTurn = false;      ///< a sequence, which can't be lowered while it plays
        bool isAbandoned = false; ///< silenced by the hold, with no field since
        double cap = 1;           ///< amplitude cap that it respects
    };
    /// Whether the device becomes quieter on request, and the reports about it.
    struct Quieting
    {
        QuietWatch watch;
        double patience_s = QuietWatch::kConfirm_s;
        std::string quieted;    ///< DeviceReport::quieted
        std::string unsilenced; ///< DeviceReport::unsilenced, as far as known here
        std::uint64_t faults = 0;
    };
    /// For report(): counters that the device doesn't have.
    struct Counts
    {
        std::uint64_t refused = 0;
        std::uint64_t silences = 0;
    };
    /// The thread: started at once for limits that need time, otherwise on demand.
    struct Watchman
    {
        std::thread thread;
        double wakeAt_s = std::numeric_limits<double>::infinity(); ///< end of its sleep
        bool closing = false;
    };

    std::shared_ptr<Lead> lead() const { return std::atomic_load(&_lead); }
    /// The lower of the cap at opening and the lead's. Another thread may change it at any time:
    /// each send reads it once.
    double cap() const;
    bool refuse() MIDAIR_REQUIRES(_mutex);
    bool sendLowered(const std::shared_ptr<JointCommit>& joint = nullptr) MIDAIR_REQUIRES(_mutex);
    void silenceLocked() MIDAIR_REQUIRES(_mutex);
    void noteSilence() MIDAIR_REQUIRES(_mutex);
    void ask(const std::optional<Loudness>& level, double asked_s, bool taken = true)
        MIDAIR_REQUIRES(_mutex);
    void settle() const MIDAIR_REQUIRES(_mutex);
    bool maySound() const MIDAIR_REQUIRES(_mutex);
    void watchHold() MIDAIR_REQUIRES(_mutex);
    void watchQuieting() MIDAIR_REQUIRES(_mutex);
    double nextDue_s() const MIDAIR_REQUIRES(_mutex); ///< time when run() is due
    void wake() MIDAIR_REQUIRES(_mutex);
    void run() MIDAIR_EXCLUDES(_mutex);

    const std::unique_ptr<DeviceClaim> _claim; ///< outlives the device
    const std::unique_ptr<ArrayDevice> _device;
    const SafetyLimits _limits;
    const int _transducers;
    const base::Clock& _clock;

    std::shared_ptr<Lead> _lead; ///< never null; loaded and stored atomically

    mutable base::Mutex _mutex;
    base::Condition _wake;
    LimitedDrive _drive MIDAIR_GUARDED_BY(_mutex);
    Sounding _sounding MIDAIR_GUARDED_BY(_mutex);
    mutable Quieting _quieting MIDAIR_GUARDED_BY(_mutex); ///< of output handed to the device
    Counts _counts MIDAIR_GUARDED_BY(_mutex);
    Watchman _watchman MIDAIR_GUARDED_BY(_mutex);
};

/// Throws DeviceError for limits that are out of range.
void checkLimits(const SafetyLimits& limits);

/// Takes the limits from the URI's parameters and combines them with \a limits, see SafetyLimits.
SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits);

/// Returns the lower of two caps of a pressure or level; 0 means none.
double stricterCap(double a, double b);

} // namespace midair::device
