#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"
#include "haptics/base/threads/Mutex.h"

#include <functional>
#include <random>

namespace midair::device::emulation
{

/// The clock of emulated units and of who waits for them: base::steadySeconds(), in ns.
class EmulatedTime
{
public:
    virtual ~EmulatedTime() = default;
    virtual Time_ns now_ns();
    /// Waits until \a until_ns, \a changed, or sooner; \a lock holds \a mutex, which is released
    /// meanwhile.
    virtual void
    wait(base::Mutex& mutex, base::Lock& lock, base::Condition& changed, Time_ns until_ns)
        MIDAIR_REQUIRES(mutex);
};

/// Time that passes only where somebody waits or looks at it: as fast as the processor plays it,
/// and the same way each time. For one thread at a time, which is the host that is simulated.
class VirtualTime : public EmulatedTime
{
public:
    /// A computer that takes time, and sometimes stands still.
    struct Host
    {
        Time_ns look_ns = 1'000;  ///< from one look at the clock, or datagram, to the next
        Time_ns wake_ns = 20'000; ///< that a wait takes longer than it should
        double pausesPerSecond = 0;
        Time_ns pause_ns = 0; ///< mean; their lengths and distances are exponential
        unsigned seed = 1;
    };
    using Call = std::function<void(Time_ns)>;

    /// Calls \a call every \a period_ns > 0, where somebody waits.
    VirtualTime(const Host& host, Time_ns period_ns, Call call);

    Time_ns now_ns() override MIDAIR_EXCLUDES(_mutex);
    void
    wait(base::Mutex& mutex, base::Lock& lock, base::Condition& changed, Time_ns until_ns) override
        MIDAIR_REQUIRES(mutex);

private:
    Time_ns exponential(double mean_ns) MIDAIR_REQUIRES(_mutex);

    const Host _host;
    const Time_ns _period_ns;
    const Call _call;
    Time_ns _nextCall_ns; ///< used by the host's thread
    base::Mutex _mutex;
    std::mt19937 _random MIDAIR_GUARDED_BY(_mutex);
    Time_ns _now_ns MIDAIR_GUARDED_BY(_mutex) = 1'000'000'000;
    Time_ns _nextPause_ns MIDAIR_GUARDED_BY(_mutex) = kNever_ns;
};

} // namespace midair::device::emulation
