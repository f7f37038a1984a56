#include "device/autd3/Autd3Account.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

namespace midair::device::autd3
{

Autd3Account::Autd3Account(int units)
{
    _told.report.state = DeviceState::LOST;
    _told.playing.isLost.resize(static_cast<std::size_t>(units));
}

bool Autd3Account::order(std::shared_ptr<Job> job)
{
    const base::Lock lock(_mutex);
    ++_told.report.sent;
    if (job == nullptr || _told.report.state == DeviceState::LOST || _link == nullptr)
    {
        ++_told.report.refused;
        return false;
    }
    if (_orders.job != nullptr) ++_told.report.dropped;
    job->sentAt_s = _link->now_s();
    _orders.job = std::move(job);
    _isOrdered = true;
    wake();
    return true;
}

void Autd3Account::orderSilence()
{
    const base::Lock lock(_mutex);
    if (std::exchange(_orders.job, nullptr) != nullptr) ++_told.report.dropped;
    _orders.silence = true;
    _orders.silence_s = base::steadySeconds();
    _isOrdered = true;
    _told.playing.job = nullptr;
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

DeviceReport Autd3Account::report() const
{
    const base::Lock lock(_mutex);
    DeviceReport report = _told.report;
    report.pending = report.sent - report.played - report.dropped - report.lost - report.refused;
    return report;
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
    _told.report.firmware = firmware;
    _told.report.state = DeviceState::READY;
    _told.report.reconnects += isBack ? 1 : 0;
    _orders = {};
    _told.playing = {nullptr, 0, std::vector<bool>(_told.playing.isLost.size())};
}

void Autd3Account::detach(const std::string& why, int lost, int dropped)
{
    const base::Lock lock(_mutex);
    _told.report.lost += static_cast<std::uint64_t>(lost);
    _told.report.dropped += static_cast<std::uint64_t>(dropped + (_orders.job ? 1 : 0));
    _orders = {};
    _told.playing.job = nullptr;
    _link.reset();
    if (why.empty()) return;
    _told.countFault(why);
    _told.report.state = DeviceState::LOST;
}

bool Autd3Account::takeOrders(Orders& orders)
{
    const base::Lock lock(_mutex);
    if (!std::exchange(_isOrdered, false)) return false;
    orders = std::exchange(_orders, {});
    return true;
}

void Autd3Account::notePlayed(const std::shared_ptr<const Job>& job,
                              double handedOver_s,
                              double offset_ns)
{
    const base::Lock lock(_mutex);
    ++_told.report.played;
    _told.confirm(job->sentAt_s);
    _told.report.lastHandedOver_s = handedOver_s;
    _told.report.latency_s = handedOver_s - job->sentAt_s;
    if (_orders.silence) return;
    _told.playing.job = job;
    _told.playing.offset_ns = offset_ns;
}

} // namespace midair::device::autd3
