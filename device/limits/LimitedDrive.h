#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveSignal.h"

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
    /// The device has taken the last lowered(), or else plays nothing of it.
    void noteSent(bool taken);
    /// A sequence plays, lowered by \a gain as a whole. Ramp and budget let none be sent.
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

} // namespace midair::device
