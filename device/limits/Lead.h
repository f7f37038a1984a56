#pragma once

#include "haptics/base/threads/SteadyClock.h"

#include <atomic>
#include <cstdint>

namespace midair::device
{

/// Requests of the application that leads an array: mute, amplitude cap, signs of life. They are
/// stored only here, whichever device plays and whether or not it is open. Guarded devices follow a
/// lead (ArrayDevice::follow()); all devices of a list follow the same one, and code in front of
/// them queries it.
///
/// It only stores. The device's functions of the same names change the output and record the
/// request here; a device that is opened later reads it. Any thread may call any member; none
/// waits.
class Lead
{
public:
    /// Construction counts as a sign of life. \a clock must outlive it.
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
    /// Number of mutes: distinguishes output before a mute from output after it.
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
