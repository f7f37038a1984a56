#pragma once

#include "haptics/base/threads/SteadyClock.h"

#include <atomic>
#include <cstdint>

namespace midair::device
{

/// What whoever leads an array has asked of it: that it is muted, a cap of the amplitude, signs of
/// life. It is kept here alone, whichever device plays and whether one is open by now. Guarded
/// devices follow it (ArrayDevice::follow()), several of a list the same one, and whatever stands
/// before them asks it.
///
/// It only remembers. What sounds is changed by the device's functions of the same names, which
/// write it down here; a device that is opened later finds it. All members may be called from any
/// thread and never wait.
class Lead
{
public:
    /// Making it counts as a sign of life. \a clock has to outlive it.
    explicit Lead(const base::Clock& clock = base::steadyClock()) :
        _clock(clock),
        _sign_s(clock.now_s())
    {
    }

    void setMuted(bool muted)
    {
        if (!_muted.exchange(muted) && muted) ++_mutes;
    }
    bool isMuted() const { return _muted; }
    /// How often it was muted: tells what was played before a mute from what came after.
    std::uint64_t mutes() const { return _mutes; }

    /// \a amplitude: 0 .. 1 of full drive; anything else counts as 0.
    void setAmplitudeCap(double amplitude)
    {
        _cap = amplitude >= 0 && amplitude <= 1 ? amplitude : 0; // also for NaN
    }
    double amplitudeCap() const { return _cap; }

    void keepAlive() { _sign_s = _clock.now_s(); }
    double sign_s() const { return _sign_s; } ///< time of the last sign of life

private:
    const base::Clock& _clock;
    std::atomic<bool> _muted{false};
    std::atomic<std::uint64_t> _mutes{0};
    std::atomic<double> _cap{1.0};
    std::atomic<double> _sign_s;
};

} // namespace midair::device
