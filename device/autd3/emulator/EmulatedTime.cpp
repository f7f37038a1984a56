#include "device/autd3/emulator/EmulatedTime.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::device::emulation
{

Time_ns EmulatedTime::now_ns()
{
    return static_cast<Time_ns>(base::steadySeconds() * 1e9);
}

void EmulatedTime::wait(base::Mutex&, base::Lock& lock, base::Condition& changed, Time_ns until_ns)
{
    changed.waitUntil_s(lock, static_cast<double>(until_ns) * 1e-9);
}

VirtualTime::VirtualTime(const Host& host, Time_ns period_ns, Call call) :
    _host(host),
    _period_ns(period_ns),
    _call(std::move(call)),
    _random(host.seed)
{
    _nextCall_ns = _now_ns + period_ns;
    if (_host.pausesPerSecond > 0)
        _nextPause_ns = _now_ns + exponential(1e9 / _host.pausesPerSecond);
}

Time_ns VirtualTime::exponential(double mean_ns)
{
    return static_cast<Time_ns>(
        std::llround(std::exponential_distribution<double>(1 / mean_ns)(_random)));
}

Time_ns VirtualTime::now_ns()
{
    const base::Lock lock(_mutex);
    _now_ns += _host.look_ns;
    while (_now_ns >= _nextPause_ns)
    {
        _now_ns = _nextPause_ns + exponential(static_cast<double>(_host.pause_ns));
        _nextPause_ns = _now_ns + exponential(1e9 / _host.pausesPerSecond);
    }
    return _now_ns;
}

void VirtualTime::wait(base::Mutex& mutex, base::Lock&, base::Condition&, Time_ns until_ns)
{
    const bool isCall = _nextCall_ns <= until_ns;
    const Time_ns wanted_ns = isCall ? _nextCall_ns : until_ns + _host.wake_ns;
    {
        const base::Lock own(_mutex);
        _now_ns = std::max(_now_ns, wanted_ns);
    }
    if (!isCall) return;
    _nextCall_ns += _period_ns;
    const base::Unlocked unlocked(mutex);
    _call(wanted_ns);
}

} // namespace midair::device::emulation
