#pragma once

#include "device/ArrayDevice.h"
#include "device/limits/DeviceClaim.h"
#include "device/limits/KeptAlive.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace midair::device
{

class DeviceUri;

/// Wraps a device and enforces its limits: amplitude cap, ramp, thermal budget, hold, mute.
/// Everything that reaches the device goes through here.
///
/// With a ramp, thermal budget or hold, a thread resends the last field with another gain as time
/// passes, or silences it.
class GuardedDevice : public ArrayDevice, public KeptAlive
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

    bool send(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return _device->canStage(); }
    bool sendTogether(const DriveSignal& signal,
                      const std::shared_ptr<JointCommit>& joint) override;
    /// Refuses all sequences with a ramp, thermal budget or hold, since the gain of a sequence
    /// can't be changed while the device plays it.
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    void setMuted(bool muted) override;
    bool setAmplitudeCap(double amplitude) override;
    void keepAlive() override;
    double hold_s() const override { return _limits.hold_s; }
    std::string status() const override;
    DeviceReport report() const override;
    DriveAbility ability() const override; ///< no sequences with a ramp, a thermal budget or a hold
    bool identify(int board, bool light) override { return _device->identify(board, light); }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<PlayedField> playedSince(double from_s) const override
    {
        return _device->playedSince(from_s);
    }
    std::vector<std::complex<float>> wouldPlay(const DriveSignal& signal) const override;

private:
    bool limitsNeedTime() const;
    bool sendScaled(double now_s, const std::shared_ptr<JointCommit>& joint = nullptr);
    double capGain(const DriveSignal& signal) const; ///< for the amplitude cap only
    double allowedGain(double now_s);
    void account(double now_s);
    void noteSilence();
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
    double _wantedPeak = 0;               ///< largest amplitude of _wanted
    double _wantedDrive = 0;              ///< mean of its amplitudes squared
    double _ramp = 0;                     ///< 0 .. 1; gain of the ramp
    double _meanDrive = 0;                ///< mean over time of _drive
    double _drive = 0;                    ///< mean amplitude squared of what is played
    double _gain = 1;                     ///< gain of what is played
    double _accounted_s = 0;              ///< time of _meanDrive
    std::atomic<double> _lastWanted_s{0}; ///< the last field, or keepAlive()
    bool _sounds = false;
    bool _inTurn = false; ///< what sounds is a sequence, which can't be lowered while it plays
    bool _muted = false;
    bool _closing = false;
    std::uint64_t _refused = 0;
    std::uint64_t _silences = 0;
    std::thread _thread;
};

/// Takes the limits from the URI's parameters and combines them with \a limits, see SafetyLimits.
SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits);

/// The lower of two pressure caps; 0 means none.
double stricterPressure(double a_Pa, double b_Pa);

/// Sets \a scaled to \a signal with all amplitudes multiplied by \a gain (0 .. 1) and rounded down
/// to duty levels, so that no limit is exceeded.
void scaleDuties(const DriveSignal& signal, double gain, DriveSignal& scaled);

} // namespace midair::device
