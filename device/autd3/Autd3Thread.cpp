#include "device/DeviceLog.h"
#include "device/autd3/Autd3Device.h"
#include "device/autd3/Opening.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

#include <fmt/format.h>
#include <sched.h>
#include <spdlog/spdlog.h>

// What the thread of an Autd3Device does.
namespace midair::device::autd3
{

namespace
{

constexpr double kReopen_s = 0.25;
constexpr double kFarewell_s = 0.2;
constexpr double kLastMask_s = 0.05; // for the others, when a unit is lost
// How often heartbeats' answers are waited for, for the clock (UnitClock::kWindow_s): each wakes
// the thread.
constexpr double kPrompt_s = 0.1;
constexpr double kPromptAtRest_s = 0.3;
constexpr double kPublish_s = 0.05;
constexpr double kFaultLog_s = 1; // at most so often; all are counted
constexpr int kMostTries = 5;     // of a field that units were told too late of

double threadCpu_s()
{
    timespec used{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) + static_cast<double>(used.tv_nsec) * 1e-9;
}

// A thread that is woken late by some ms tells units too late: it goes before others, where the
// system allows that, and sleeps most of the time. Guards and other children don't.
void askForPriority()
{
    sched_param priority{};
    priority.sched_priority = 1;
    ::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &priority); // this thread
}

} // namespace

bool Autd3Device::isClosedWithin(double atMost_s)
{
    std::unique_lock<std::mutex> lock(_mutex);
    return _wake.wait_for(
        lock, std::chrono::duration<double>(atMost_s), [&] { return _closing.load(); });
}

void Autd3Device::noteFault(const std::string& what)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_report.faults;
    _report.message = what;
}

void Autd3Device::drop(const std::shared_ptr<const Job>& job)
{
    if (job == nullptr) return;
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_report.dropped;
}

void Autd3Device::connect(bool isBack)
{
    const auto isLeft = [this] { return isClosing(); };
    std::shared_ptr<DatagramLink> link = _opener(isLeft);
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _link = link;
    }
    Opening opening(*link, _refusals, _options, _name, isLeft);
    _group = opening.open();
    _group->onOther([this](const Endpoint& from, const Answer& answer) { takeInfo(from, answer); });
    _back.clear();
    _player = std::make_unique<BankPlayer>(*_group, _options);
    const auto units = static_cast<std::size_t>(_options.units);
    _isHot.assign(units, false);
    _isOutOfStep.assign(units, false);
    _looped_s = _asked_s = _opened_s = link->now_s();
    const std::lock_guard<std::mutex> lock(_mutex);
    _firmware = opening.firmware();
    _report.state = DeviceState::READY;
    _report.reconnects += isBack ? 1 : 0;
    _orders = {};
    _playing = {};
    _playing.isLost.assign(units, false);
}

void Autd3Device::disconnect(const std::string& why)
{
    const bool isPlayed = _player != nullptr && _player->cut() != nullptr;
    _player.reset();
    _group.reset();
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _report.lost += isPlayed ? 1 : 0;
        _report.dropped += (std::exchange(_next, nullptr) ? 1 : 0) + (_orders.job ? 1 : 0);
        _orders = {};
        _playing.job = nullptr;
        _link.reset();
        if (why.empty()) return;
        ++_report.faults;
        _report.message = why;
        _report.state = DeviceState::LOST;
    }
    deviceLog().error("{}: {}; silent until it is back", _name, why);
}

void Autd3Device::run()
{
    askForPriority();
    std::string refusal;
    for (;;)
    {
        if (_group != nullptr)
        {
            const std::string why = play();
            disconnect(why);
            if (why.empty()) return; // closed
        }
        if (isClosedWithin(kReopen_s)) return;
        try
        {
            connect(true);
            refusal.clear();
            deviceLog().info("{}: back, silent until the next field", _name);
        }
        catch (const DeviceError& error)
        {
            if (refusal != error.what() && !isClosing()) // each reason once
                deviceLog().warn("{}", error.what());
            refusal = error.what();
        }
    }
}

void Autd3Device::obey()
{
    Orders orders;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (!std::exchange(_isOrdered, false)) return;
        orders = std::exchange(_orders, {});
    }
    if (orders.silence)
    {
        drop(_player->silence());
        drop(std::exchange(_next, nullptr));
        _silence_s = orders.silence_s;
    }
    if (orders.job == nullptr) return;
    if (!orders.job->isSequence()) drop(_player->abandonSequence());
    drop(std::exchange(_next, std::move(orders.job)));
    _tries = 0;
}

void Autd3Device::startNext()
{
    if (_next != nullptr && _player->isReady()) _player->start(std::exchange(_next, nullptr));
}

void Autd3Device::settle(const BankPlayer::Ending& ending)
{
    if (ending.fate == BankPlayer::Fate::DISTURBED)
    {
        if (_next != nullptr) return drop(ending.job); // a newer one waits
        if (++_tries < kMostTries)
        {
            _next = ending.job;
            return;
        }
    }
    const bool isPlayed = ending.fate == BankPlayer::Fate::PLAYED;
    if (isPlayed) _tries = 0;
    const double offset_ns = _group->clock().at_ns(ending.handedOver_s) - ending.handedOver_s * 1e9;
    const std::lock_guard<std::mutex> lock(_mutex);
    if (!isPlayed)
    {
        ++_report.lost;
        ++_report.faults;
        if (ending.fate == BankPlayer::Fate::DISTURBED)
            _report.message = fmt::format("a field came too late for some unit {} times; a longer "
                                          "lead than {:g} ms would help",
                                          kMostTries,
                                          _options.lead_s * 1e3);
        return;
    }
    ++_report.played;
    _confirmed_s = std::max(_confirmed_s, ending.job->sentAt_s);
    _report.lastHandedOver_s = ending.handedOver_s;
    _report.latency_s = ending.handedOver_s - ending.job->sentAt_s;
    if (_orders.silence) return;
    _playing.job = ending.job;
    _playing.offset_ns = offset_ns;
}

void Autd3Device::settleEndings()
{
    for (const BankPlayer::Ending& ending : _player->takeEndings())
        settle(ending);
    const std::string fault = _player->takeFault();
    if (!fault.empty())
    {
        noteFault(fault);
        const double now_s = _group->link().now_s();
        if (now_s - _faultLogged_s < kFaultLog_s) return;
        _faultLogged_s = now_s;
        deviceLog().warn("{}: {}", _name, fault);
    }
}

void Autd3Device::takeOutcomes(double now_s)
{
    for (const UnitGroup::Outcome& outcome : _group->takeOutcomes())
        if (outcome.done.code == kReadFpgaStateCode)
            watch(outcome);
        else
            _player->take(outcome);
    _player->step(now_s);
    settleEndings();
    if (_silence_s <= 0 || !_player->isSilent()) return;
    const std::lock_guard<std::mutex> lock(_mutex);
    _confirmed_s = std::max(_confirmed_s, std::exchange(_silence_s, 0));
}

// Nothing is on its way but heartbeats, whose answers can wait for the next ones: then the thread
// wakes once for all of them.
void Autd3Device::receive(double now_s)
{
    const double until_s = std::min(_group->due_s(), _player->due_s());
    const bool isQuiet = _player->isReady() && _next == nullptr && _group->isIdle();
    const double prompt_s = _group->isResting() ? kPromptAtRest_s : kPrompt_s;
    if (!isQuiet || now_s - _heardPromptly_s > prompt_s)
    {
        _group->receive(until_s);
        if (isQuiet && _group->link().now_s() >= until_s) _heardPromptly_s = now_s;
        return;
    }
    _group->link().rest(until_s);
    _group->receive(0, false);
}

void Autd3Device::publish(double now_s)
{
    if (now_s - _published_s < kPublish_s) return;
    _published_s = now_s;
    watchClocks(now_s);
    const double cpu_s = threadCpu_s();
    const std::lock_guard<std::mutex> lock(_mutex);
    _report.complaint = complaint();
    _refusalText = _refusals.text();
    _figures = {cpu_s,
                _group->repeats(),
                _player->takenBack(),
                _player->torn(),
                _refusals.total(),
                _player->lead_s()};
}

void Autd3Device::sayFarewell()
{
    drop(_player->silence());
    const double atMost_s = isClosing() ? kFarewell_s : kLastMask_s;
    const double until_s = _group->link().now_s() + atMost_s;
    for (double now_s = 0; now_s < until_s && !_player->isSilent();)
    {
        now_s = _group->link().now_s();
        _group->pump(now_s);
        _group->receive(std::min(until_s, _group->due_s()));
        takeOutcomes(now_s);
        _group->findLost(now_s);
    }
}

std::string Autd3Device::play()
{
    for (;;)
    {
        double now_s = _group->link().now_s();
        if (isClosing())
        {
            sayFarewell();
            return {};
        }
        // Stopped for so long, units may have fallen silent, and nobody else tells.
        const bool wasStopped = now_s - _looped_s > _options.failsafe_s / 2;
        if (wasStopped) _group->forgive(now_s);
        askStates(now_s, wasStopped);
        _looped_s = now_s;
        obey();
        startNext();
        _player->step(now_s);
        _group->pump(now_s);
        receive(now_s);
        now_s = _group->link().now_s();
        takeOutcomes(now_s);
        startNext();
        _group->pump(now_s);
        std::string why = losses(now_s);
        if (why.empty()) why = returns(now_s);
        if (!why.empty())
        {
            sayFarewell();
            return why;
        }
        publish(now_s);
    }
}

} // namespace midair::device::autd3
