#pragma once

#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <chrono>

namespace midair::base
{

/// Returns the steady clock in seconds, the time base of fields and snapshots.
inline double steadySeconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Clock for code with deadlines and periods; its threads wait on it. It is passed in, so that
/// tests can set the time. Any thread.
class Clock
{
public:
    virtual ~Clock() = default;

    virtual double now_s() const = 0; ///< never decreases
    /// Waits until \a condition is notified, at most until \a until_s. May wake spuriously, as
    /// Condition does.
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
        constexpr double kLong_s = 3600.0; // longer times may not fit into a time point
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
