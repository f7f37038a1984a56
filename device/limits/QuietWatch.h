#pragma once

#include "device/drive/DriveSignal.h"
#include "device/drive/EncoderKernels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace midair::device
{

/// Loudness of a field, as far as known without its points; silence is {}.
struct Loudness
{
    int peak = 0;          ///< its largest duty level
    std::uint32_t sum = 0; ///< of its duty levels

    static Loudness of(const DriveSignal& signal)
    {
        Loudness all;
        addDuties(signal.duty.data(), static_cast<int>(signal.duty.size()), &all.peak, &all.sum);
        return all;
    }
    void raiseTo(const Loudness& other)
    {
        peak = std::max(peak, other.peak);
        sum = std::max(sum, other.sum);
    }
    bool isBelow(const Loudness& other) const { return peak < other.peak || sum < other.sum; }
};

/// Watches whether a device has become quieter on request: by a quieter field or a silence, for any
/// reason (a cap, a mute, a lower target). The request is confirmed when ArrayDevice::confirmed_s()
/// reaches its time. GuardedDevice silences devices that don't confirm in time.
///
/// Has no lock: the owner guards it. All times are of the owner's clock.
class QuietWatch
{
public:
    /// Time for the device's confirmation, unless its line is slower.
    static constexpr double kConfirm_s = 0.1;
    /// A device that has not even confirmed its silence for this time hangs.
    static constexpr double kHangs_s = 1.0;

    /// A field with the loudness \a level was handed to the device at \a now_s; \a taken: not
    /// refused. Call confirm() before, so that the present output is known.
    void ask(const Loudness& level, double now_s, bool taken)
    {
        _isSilence = false;
        _due.ask(level, now_s);
        _dueAfter.ask(level, now_s);
        _last = level;
        _last_s = now_s;
        _isRefused = !taken;
    }

    /// The first unconfirmed silence counts, even if others are requested meanwhile: a device may
    /// take longer for one than the owner's retry interval.
    void askSilence(double now_s)
    {
        ask({}, now_s, true);
        _isSilence = true;
        if (_silence_s > 0) return;
        _silence_s = now_s;
        _dueAfter = {};
    }

    /// The device has carried out the requests before \a confirmed_s.
    void confirm(double confirmed_s)
    {
        if (_isRefused) confirmed_s = std::min(confirmed_s, std::nextafter(_last_s, 0));
        if (_silence_s > 0 && confirmed_s >= _silence_s)
        {
            _due = _dueAfter;
            _silence_s = _doubted_s = 0;
        }
        _isDone = confirmed_s >= _last_s;
        if (_isDone) _due.most = _dueAfter.most = _last;
        _due.confirm(confirmed_s);
        _dueAfter.confirm(confirmed_s);
        if (_due.since_s <= 0) _doubted_s = _tried_s = 0;
    }

    /// Time of the first unconfirmed quieter request; 0: none.
    double since_s() const { return _due.since_s; }
    /// The same, or the time of the silence that followed it.
    double tried_s() const { return std::max(_due.since_s, _tried_s); }
    bool isOverdue(double now_s, double patience_s) const
    {
        return _due.since_s > 0 && now_s - tried_s() > patience_s;
    }
    /// Reports that the owner silences the device now because a request is overdue.
    void doubt(double now_s)
    {
        if (_doubted_s <= 0) _doubted_s = _due.since_s;
        askSilence(now_s);
        _tried_s = now_s;
    }
    /// Time of the request whose silence isn't confirmed either; 0: none.
    double doubted_s() const { return _doubted_s; }

    bool maySound() const { return _due.most.peak > 0; } ///< as far as confirmed
    /// Returns true if the newest field is confirmed and not silent.
    bool sounds() const { return _isDone && _last.peak > 0; }
    bool isSilence() const { return _isSilence; } ///< the newest request was for silence
    void forget() { *this = {}; }                 ///< the device is lost, and begins in silence

private:
    struct Due
    {
        /// Loudest possible output: the last confirmed field, and all after it.
        Loudness most;
        double since_s = 0;
        double quieter_s = 0; ///< time of the last quieter request

        void ask(const Loudness& level, double now_s)
        {
            if (level.isBelow(most))
            {
                quieter_s = now_s;
                if (since_s <= 0) since_s = now_s;
            }
            most.raiseTo(level);
        }
        void confirm(double confirmed_s)
        {
            if (since_s > 0 && confirmed_s >= since_s)
                since_s = confirmed_s >= quieter_s ? 0 : confirmed_s;
        }
    };

    Due _due;
    Due _dueAfter;         ///< what is due after the silence of _silence_s is confirmed
    double _silence_s = 0; ///< 0: no unconfirmed silence
    Loudness _last;
    double _last_s = 0;
    bool _isRefused = false; ///< the last one was
    bool _isSilence = false;
    bool _isDone = true; ///< the newest request is confirmed
    double _doubted_s = 0;
    double _tried_s = 0; ///< time of the silence for an overdue request
};

} // namespace midair::device
