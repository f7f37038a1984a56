#pragma once

#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <chrono>

namespace midair::base
{

/// Returns the time of the steady clock in seconds, which time stamps of fields and snapshots use.
inline double steadySeconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// What tells the time to those whose limits and beats depend on it, and lets their threads wait
/// for it. It is passed in, so that a test can set it. All members may be called from any thread.
class Clock
{
public:
    virtual ~Clock() = default;

    virtual double now_s() const = 0; ///< never goes back
    /// Waits until \a condition is notified, but no longer than until \a until_s. It may return
    /// earlier without cause, as a Condition may.
    virtual void wait(Condition& condition, Lock& lock, double until_s) const = 0;
};

/// The steady clock of this machine: its time is that of steadySeconds().
class SteadyClock final : public Clock
{
public:
    double now_s() const override { return steadySeconds(); }
    void wait(Condition& condition, Lock& lock, double until_s) const override
    {
        using std::chrono::steady_clock;
        constexpr double kLong_s = 3600.0; // what is further away may not fit into a time point
        const std::chrono::duration<double> until(std::min(until_s, steadySeconds() + kLong_s));
        condition.waitUntil(
            lock,
            steady_clock::time_point(std::chrono::duration_cast<steady_clock::duration>(until)));
    }
};

inline const Clock& steadyClock()
{
    static const SteadyClock clock;
    return clock;
}

} // namespace midair::base
