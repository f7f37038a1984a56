#pragma once

#include "device/drive/DriveSignal.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace midair::device
{

/// How loud a field is, as far as that can be told without its points; silence is {}.
struct Loudness
{
    int peak = 0;          ///< its largest duty level
    std::uint32_t sum = 0; ///< of its duty levels

    static Loudness of(const DriveSignal& signal)
    {
        Loudness loudness;
        for (const std::uint8_t duty : signal.duty)
        {
            loudness.peak = std::max<int>(loudness.peak, duty);
            loudness.sum += duty;
        }
        return loudness;
    }
    void raiseTo(const Loudness& other)
    {
        peak = std::max(peak, other.peak);
        sum = std::max(sum, other.sum);
    }
    bool isBelow(const Loudness& other) const { return peak < other.peak || sum < other.sum; }
};

/// Watches whether what was asked to become quieter has become so: a quieter field or a silence,
/// whatever it was for (a cap, a mute, a lower target). It has once ArrayDevice::confirmed_s() has
/// reached the asking. GuardedDevice silences what isn't confirmed in time.
///
/// Has no lock: the owner guards it. All times are those of the owner's clock.
class QuietWatch
{
public:
    /// Within this time the device has to confirm, where its line is not slower.
    static constexpr double kConfirm_s = 0.1;
    /// What has not even confirmed its silence for so long hangs.
    static constexpr double kHangs_s = 1.0;

    /// A field as loud as \a level was handed to the device at \a now_s; \a taken: it has not
    /// refused it. Call confirm() before, so that what sounds is known.
    void ask(const Loudness& level, double now_s, bool taken)
    {
        _isSilence = false;
        _due.ask(level, now_s);
        _dueAfter.ask(level, now_s);
        _last = level;
        _last_s = now_s;
        _isRefused = !taken;
    }

    /// The first silence that isn't confirmed counts, though others are asked for meanwhile: a
    /// device may take longer for one than the owner waits until it asks again.
    void askSilence(double now_s)
    {
        ask({}, now_s, true);
        _isSilence = true;
        if (_silence_s > 0) return;
        _silence_s = now_s;
        _dueAfter = {};
    }

    /// The device has carried out what was asked for before \a confirmed_s.
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

    /// Since when something quieter isn't confirmed; 0: nothing.
    double since_s() const { return _due.since_s; }
    /// The same, or since when it was silenced for that.
    double tried_s() const { return std::max(_due.since_s, _tried_s); }
    bool isOverdue(double now_s, double patience_s) const
    {
        return _due.since_s > 0 && now_s - tried_s() > patience_s;
    }
    /// The owner silences it now, for it is overdue.
    void doubt(double now_s)
    {
        if (_doubted_s <= 0) _doubted_s = _due.since_s;
        askSilence(now_s);
        _tried_s = now_s;
    }
    /// When that was asked for whose silence isn't confirmed, either; 0: nothing.
    double doubted_s() const { return _doubted_s; }

    bool maySound() const { return _due.most.peak > 0; } ///< as far as it has confirmed
    /// The newest field is confirmed, and is no silence.
    bool sounds() const { return _isDone && _last.peak > 0; }
    bool isSilence() const { return _isSilence; } ///< the newest asking was for one
    void forget() { *this = {}; }                 ///< the device is lost, and begins in silence

private:
    struct Due
    {
        /// The loudest that may sound: what was confirmed last, and all that came since.
        Loudness most;
        double since_s = 0;
        double quieter_s = 0; ///< when something quieter was asked for last

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
    Due _dueAfter;         ///< what is due once the silence of _silence_s is confirmed
    double _silence_s = 0; ///< 0: none isn't confirmed
    Loudness _last;
    double _last_s = 0;
    bool _isRefused = false; ///< the last one was
    bool _isSilence = false;
    bool _isDone = true; ///< the last one is confirmed
    double _doubted_s = 0;
    double _tried_s = 0; ///< when it was silenced for what is overdue
};

} // namespace midair::device
