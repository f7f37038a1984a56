#include "device/autd3/Autd3Account.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

namespace midair::device::autd3
{

Autd3Account::Autd3Account(int units)
{
    _report.state = DeviceState::LOST;
    _playing.isLost.resize(static_cast<std::size_t>(units));
}

void Autd3Account::wake()
{
    if (_link != nullptr) _link->wake();
}

void Autd3Account::countFault(const std::string& what)
{
    ++_report.faults;
    _report.message = what;
}

bool Autd3Account::order(std::shared_ptr<Job> job)
{
    const base::Lock lock(_mutex);
    ++_report.sent;
    if (job == nullptr || _report.state == DeviceState::LOST || _link == nullptr)
    {
        ++_report.refused;
        return false;
    }
    if (_orders.job != nullptr) ++_report.dropped;
    job->sentAt_s = _link->now_s();
    _orders.job = std::move(job);
    _isOrdered = true;
    wake();
    return true;
}

void Autd3Account::orderSilence()
{
    const base::Lock lock(_mutex);
    if (std::exchange(_orders.job, nullptr) != nullptr) ++_report.dropped;
    _orders.silence = true;
    _orders.silence_s = base::steadySeconds();
    _isOrdered = true;
    _playing.job = nullptr;
    wake();
}

void Autd3Account::close()
{
    {
        const base::Lock lock(_mutex);
        _isClosing = true;
        wake();
    }
    _closed.notifyAll();
}

double Autd3Account::confirmed_s() const
{
    const base::Lock lock(_mutex);
    return _confirmed_s;
}

DeviceReport Autd3Account::report() const
{
    const base::Lock lock(_mutex);
    DeviceReport report = _report;
    report.pending = report.sent - report.played - report.dropped - report.lost - report.refused;
    return report;
}

std::string Autd3Account::refusals() const
{
    const base::Lock lock(_mutex);
    return _refusals;
}

Autd3Account::Playing Autd3Account::playing() const
{
    const base::Lock lock(_mutex);
    return _playing;
}

Autd3Account::Figures Autd3Account::figures() const
{
    const base::Lock lock(_mutex);
    return _figures;
}

bool Autd3Account::isClosedWithin(double atMost_s)
{
    const double until_s = base::steadySeconds() + atMost_s;
    base::Lock lock(_mutex);
    while (!_isClosing && _closed.waitUntil_s(lock, until_s))
    {
    }
    return _isClosing;
}

void Autd3Account::attach(std::shared_ptr<DatagramLink> link)
{
    const base::Lock lock(_mutex);
    _link = std::move(link);
}

void Autd3Account::noteReady(const std::string& firmware, bool isBack)
{
    const base::Lock lock(_mutex);
    _report.firmware = firmware;
    _report.state = DeviceState::READY;
    _report.reconnects += isBack ? 1 : 0;
    _orders = {};
    _playing = {nullptr, 0, std::vector<bool>(_playing.isLost.size())};
}

void Autd3Account::detach(const std::string& why, int lost, int dropped)
{
    const base::Lock lock(_mutex);
    _report.lost += static_cast<std::uint64_t>(lost);
    _report.dropped += static_cast<std::uint64_t>(dropped + (_orders.job ? 1 : 0));
    _orders = {};
    _playing.job = nullptr;
    _link.reset();
    if (why.empty()) return;
    countFault(why);
    _report.state = DeviceState::LOST;
}

bool Autd3Account::takeOrders(Orders& orders)
{
    const base::Lock lock(_mutex);
    if (!std::exchange(_isOrdered, false)) return false;
    orders = std::exchange(_orders, {});
    return true;
}

void Autd3Account::noteFault(const std::string& what)
{
    const base::Lock lock(_mutex);
    countFault(what);
}

void Autd3Account::noteDropped(const std::shared_ptr<const Job>& job)
{
    if (job == nullptr) return;
    const base::Lock lock(_mutex);
    ++_report.dropped;
}

void Autd3Account::notePlayed(const std::shared_ptr<const Job>& job,
                              double handedOver_s,
                              double offset_ns)
{
    const base::Lock lock(_mutex);
    ++_report.played;
    _confirmed_s = std::max(_confirmed_s, job->sentAt_s);
    _report.lastHandedOver_s = handedOver_s;
    _report.latency_s = handedOver_s - job->sentAt_s;
    if (_orders.silence) return;
    _playing.job = job;
    _playing.offset_ns = offset_ns;
}

void Autd3Account::noteLost(const std::string& why)
{
    const base::Lock lock(_mutex);
    ++_report.lost;
    countFault(why.empty() ? _report.message : why);
}

void Autd3Account::noteFailsafe(const std::string& what)
{
    const base::Lock lock(_mutex);
    countFault(what);
    ++_report.silences;
    _playing.job = nullptr;
}

void Autd3Account::noteLostUnits(const std::vector<bool>& isLost)
{
    const base::Lock lock(_mutex);
    _playing.isLost = isLost;
}

void Autd3Account::noteConfirmed(double asked_s)
{
    const base::Lock lock(_mutex);
    _confirmed_s = std::max(_confirmed_s, asked_s);
}

void Autd3Account::publish(const std::string& complaint,
                           const std::string& refusals,
                           const Figures& figures)
{
    const base::Lock lock(_mutex);
    _report.complaint = complaint;
    _refusals = refusals;
    _figures = figures;
}

} // namespace midair::device::autd3
