#include "device/autd3/emulator/EmulatedLink.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::device::emulation
{

namespace
{

constexpr std::uint16_t kPort = 44336;
constexpr std::uint32_t kScope = 1;
constexpr int kNobody = -1;

// Contents of a send buffer of 8 kB on a cable of 100 Mbit/s.
constexpr Time_ns kMostBacklog_ns = 700'000;

// Address of a unit without its last byte, the id.
constexpr std::array<std::uint8_t, 16> kPrefix = {
    0xFE, 0x80, 0, 0, 0, 0, 0, 0, 0x00, 0x41, 0x55, 0xFF, 0xFE, 0x54, 0x44, 0xFF};

int idOf(const autd3::Endpoint& address)
{
    const bool isUnit = address.port == kPort &&
                        std::equal(kPrefix.begin(), kPrefix.end() - 1, address.address.begin());
    return isUnit ? address.address.back() : kNobody;
}

} // namespace

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

autd3::Endpoint EmulatedLink::addressOf(int id)
{
    autd3::Endpoint endpoint;
    endpoint.address = kPrefix;
    if (id < 0)
        endpoint.address[8] = 0x77;
    else
        endpoint.address.back() = static_cast<std::uint8_t>(id);
    endpoint.port = kPort;
    endpoint.scope = kScope;
    return endpoint;
}

bool EmulatedLink::send(int to, const std::vector<std::uint8_t>& bytes)
{
    const base::Lock lock(_units->_mutex);
    EmulatedChain& chain = _units->_chain;
    const Time_ns now_ns = _units->advance();
    if (chain.backlog_ns(now_ns) > kMostBacklog_ns)
    {
        _refused = true;
        return false;
    }
    chain.send(to, bytes.data(), bytes.size(), 0, now_ns);
    return true;
}

bool EmulatedLink::send(const autd3::Endpoint& to, const std::vector<std::uint8_t>& bytes)
{
    const int id = idOf(to);
    return id == kNobody || send(id, bytes); // nobody answers there
}

bool EmulatedLink::sendToGroup(const std::vector<std::uint8_t>& bytes)
{
    return send(kGroup, bytes);
}

bool EmulatedLink::receive(double until_s, autd3::Endpoint& from, std::vector<std::uint8_t>& bytes)
{
    const auto until_ns = static_cast<Time_ns>(std::clamp(until_s, 0.0, 9e9) * 1e9);
    base::Lock lock(_units->_mutex);
    EmulatedChain& chain = _units->_chain;
    for (;;)
    {
        const Time_ns now_ns = _units->_time->now_ns();
        EmulatedChain::Answer answer;
        if (chain.receive(answer, now_ns))
        {
            from = addressOf(answer.from);
            bytes = std::move(answer.bytes);
            return true;
        }
        const bool room = _refused && chain.backlog_ns(now_ns) <= kMostBacklog_ns / 2;
        if (_woken || room || now_ns >= until_ns)
        {
            _woken = false;
            if (room) _refused = false;
            return false;
        }
        Time_ns next_ns = std::min(until_ns, chain.nextEvent_ns());
        if (_refused)
            next_ns = std::min(next_ns, now_ns + chain.backlog_ns(now_ns) - kMostBacklog_ns / 2);
        _units->_time->wait(_units->_mutex, lock, _units->_changed, next_ns);
    }
}

void EmulatedLink::rest(double until_s)
{
    const auto until_ns = static_cast<Time_ns>(std::clamp(until_s, 0.0, 9e9) * 1e9);
    base::Lock lock(_units->_mutex);
    while (!_woken && _units->_time->now_ns() < until_ns)
        _units->_time->wait(_units->_mutex, lock, _units->_changed, until_ns);
    _woken = false;
}

void EmulatedLink::wake()
{
    const base::Lock lock(_units->_mutex);
    _woken = true;
    _units->_changed.notifyAll();
}

} // namespace midair::device::emulation
