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

/// The field that is wanted of a device, and how loud SafetyLimits let it be as time passes: cap of
/// the amplitude, ramp, thermal budget.
///
/// Has no lock: the owner guards it. Times are those of any one clock.
class LimitedDrive
{
public:
    LimitedDrive(const SafetyLimits& limits, double now_s);

    /// Ramp or budget: the gain changes while a field is held.
    bool needsTime() const { return _limits.ramp_s > 0 || _limits.meanDrive < 1; }
    /// Longest time between two looks at what changes, s.
    double step_s() const;

    void want(const DriveSignal& signal);
    /// The gain at which what is wanted may sound, with its peak at \a cap at most.
    double allowed(double cap, double now_s);
    /// Returns what is wanted, lowered by that; it stays until the next call.
    const DriveSignal& lowered(double cap, double now_s);
    /// The device has taken the last lowered(), or else refused it and plays on.
    void noteSent(bool taken);
    /// A sequence plays, whose loudest field is lowered by \a gain. Ramp and budget let none be
    /// sent.
    void noteSequence(double gain) { _gain = gain; }
    void noteSilence(double now_s);

    double gain() const { return _gain; } ///< of what is played
    bool isRampedUp() const { return _limits.ramp_s > 0 && _ramp > 0; }
    /// The ramp goes on for \a passed_s, upwards or down.
    void passRamp(double passed_s, bool upwards);
    /// Returns true if the gain would change by what is worth a field: half a duty level.
    bool isDue(double cap, double now_s);

private:
    void account(double now_s);

    const SafetyLimits _limits;
    DriveSignal _wanted;
    DriveSignal _lowered;
    double _wantedPeak = 0;  ///< largest amplitude of _wanted
    double _wantedDrive = 0; ///< mean of its amplitudes squared
    double _ramp = 0;        ///< 0 .. 1; gain of the ramp
    double _gain = 1;        ///< of what is played
    double _drive = 0;       ///< mean amplitude squared of what is played
    double _meanDrive = 0;   ///< mean of that over time
    double _accounted_s;     ///< time of _meanDrive
};

/// The largest amplitude of \a signal.
double peakAmplitude(const DriveSignal& signal);
/// The gain that lowers \a signal to a peak of \a cap; 1 if it is no louder.
double capGain(const DriveSignal& signal, double cap);

class DeviceUri;

/// Wraps a device and enforces its limits: amplitude cap, ramp, thermal budget, hold, mute.
/// Everything that reaches the device goes through here. What whoever leads has asked of it stands
/// in its Lead.
///
/// With a ramp or thermal budget a thread resends the last field with another gain as time passes.
/// It is also the one watchdog of all devices: without a sign of life for the time of the hold it
/// silences the device, whatever is sent, and what was asked to become quieter and isn't confirmed
/// in time (QuietWatch) it silences, again and again until that is confirmed.
class GuardedDevice : public ArrayDevice
{
public:
    /// Throws DeviceError for limits that are out of range. \a claim is released after the device
    /// is closed; may be null. \a clock has to outlive it; it is that of the device's
    /// confirmed_s().
    GuardedDevice(std::unique_ptr<ArrayDevice> device,
                  const SafetyLimits& limits,
                  int transducers,
                  std::unique_ptr<DeviceClaim> claim = {},
                  const base::Clock& clock = base::steadyClock());
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
    /// What the device was given last.
    struct Sounding
    {
        bool isAny = false;
        bool inTurn = false;      ///< a sequence, which can't be lowered while it plays
        bool isAbandoned = false; ///< the hold has silenced it, and no field came since
        double cap = 1;           ///< of the amplitude, to which it keeps
    };
    /// Whether the device becomes quieter when it is asked to, and what is told of it.
    struct Quieting
    {
        QuietWatch watch;
        double patience_s = QuietWatch::kConfirm_s;
        std::string quieted;    ///< DeviceReport::quieted
        std::string unsilenced; ///< DeviceReport::unsilenced, as far as seen here
        std::uint64_t faults = 0;
    };
    /// For report(): what the device doesn't know of.
    struct Counts
    {
        std::uint64_t refused = 0;
        std::uint64_t silences = 0;
    };
    /// The thread: there from the start with limits that need time, else once it is needed.
    struct Watchman
    {
        std::thread thread;
        double wakeAt_s = std::numeric_limits<double>::infinity(); ///< until then it sleeps
        bool closing = false;
    };

    std::shared_ptr<Lead> lead() const { return std::atomic_load(&_lead); }
    /// The lower of the cap that it was opened with and the lead's. Another thread may change it at
    /// any time: each sending reads it once.
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
    double nextDue_s() const MIDAIR_REQUIRES(_mutex); ///< when run() has something to do
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
    mutable Quieting _quieting MIDAIR_GUARDED_BY(_mutex); ///< of what was handed to the device
    Counts _counts MIDAIR_GUARDED_BY(_mutex);
    Watchman _watchman MIDAIR_GUARDED_BY(_mutex);
};

/// Throws DeviceError for limits that are out of range.
void checkLimits(const SafetyLimits& limits);

/// Takes the limits from the URI's parameters and combines them with \a limits, see SafetyLimits.
SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits);

/// The lower of two caps of a pressure or a level; 0 means none.
double stricterCap(double a, double b);

} // namespace midair::device
