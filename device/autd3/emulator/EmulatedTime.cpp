#include "device/autd3/emulator/EmulatedTime.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace midair::device::emulation
{

Time_ns EmulatedTime::now_ns()
{
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

void EmulatedTime::wait(std::unique_lock<std::mutex>& lock,
                        std::condition_variable& changed,
                        Time_ns until_ns)
{
    changed.wait_until(lock,
                       std::chrono::steady_clock::time_point(std::chrono::nanoseconds(until_ns)));
}

VirtualTime::VirtualTime(const Host& host, Time_ns period_ns, Call call) :
    _host(host),
    _period_ns(period_ns),
    _call(std::move(call)),
    _random(host.seed),
    _nextPause_ns(kNever_ns),
    _nextCall_ns(_now_ns + period_ns)
{
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
    const std::lock_guard<std::mutex> lock(_mutex);
    _now_ns += _host.look_ns;
    while (_now_ns >= _nextPause_ns)
    {
        _now_ns = _nextPause_ns + exponential(static_cast<double>(_host.pause_ns));
        _nextPause_ns = _now_ns + exponential(1e9 / _host.pausesPerSecond);
    }
    return _now_ns;
}

void VirtualTime::wait(std::unique_lock<std::mutex>& lock,
                       std::condition_variable&,
                       Time_ns until_ns)
{
    const bool isCall = _nextCall_ns <= until_ns;
    const Time_ns wanted_ns = isCall ? _nextCall_ns : until_ns + _host.wake_ns;
    {
        const std::lock_guard<std::mutex> own(_mutex);
        _now_ns = std::max(_now_ns, wanted_ns);
    }
    if (!isCall) return;
    _nextCall_ns += _period_ns;
    lock.unlock();
    _call(wanted_ns);
    lock.lock();
}

} // namespace midair::device::emulation
