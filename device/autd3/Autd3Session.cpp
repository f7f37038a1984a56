#include "device/autd3/Autd3Session.h"

#include "device/DeviceLog.h"
#include "device/autd3/Opening.h"
#include "device/autd3/UdpLink.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kStates_s = 1; // interval of state requests per unit
constexpr double kOutOfStep_s = 2;
constexpr double kLookForLost_s = 0.5; // interval
constexpr double kLeastReopen_s = 10;  // minimum time between reopenings for a lost unit

constexpr double kFarewell_s = 0.2;
constexpr double kLastMask_s = 0.05; // for the other units, when one is lost
// Interval of waiting for heartbeat answers, for the clock (UnitClock::kWindow_s): each wakes the
// thread.
constexpr double kPrompt_s = 0.1;
constexpr double kPromptAtRest_s = 0.3;
constexpr double kPublish_s = 0.05;
constexpr double kFaultLog_s = 1; // minimum interval; all are counted
constexpr int kMostTries = 5;     // attempts for a field that reached units too late

double threadCpu_s()
{
    timespec used{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) + static_cast<double>(used.tv_nsec) * 1e-9;
}

std::unique_ptr<UnitGroup> openUnits(Opening opening, Autd3Account& account, bool isBack)
{
    std::unique_ptr<UnitGroup> group = opening.open();
    account.noteReady(opening.firmware(), isBack);
    return group;
}

} // namespace

UnitWatch::UnitWatch(UnitGroup& group, const std::string& name, Refusals& refusals) :
    _group(group),
    _name(name),
    _refusals(refusals),
    _told(static_cast<std::size_t>(group.size()))
{
    _asking.last_s = _looking.opened_s = group.link().now_s();
    group.onOther([this](const Endpoint& from, const Answer& answer) { takeInfo(from, answer); });
}

// One unit after the other, so that fields don't wait for sixteen answers at once; at rest all
// together, so that the thread wakes once.
void UnitWatch::askStates(double now_s, bool all)
{
    if (!all && _group.isResting())
    {
        if (now_s - _asking.last_s < kStates_s) return;
        _asking.last_s = now_s;
        all = true;
    }
    if (all)
        for (int k = 0; k < _group.size(); ++k)
            _group.push(k, Command::readFpgaState());
    const double step_s = kStates_s / _group.size();
    while (now_s - _asking.last_s >= step_s)
    {
        _asking.last_s = std::max(_asking.last_s + step_s, now_s - kStates_s);
        _asking.next = (_asking.next + 1) % _group.size();
        if (!all) _group.push(_asking.next, Command::readFpgaState());
    }
}

bool UnitWatch::takeState(const UnitGroup::Outcome& outcome)
{
    const int k = outcome.unit;
    if (!outcome.done.result) _group.push(k, Command::readFpgaState()); // its answer was lost
    if (outcome.done.data.size() != 1) return false;
    const std::uint8_t state = outcome.done.data.front();
    const bool isHot = (state & IS_HOT) != 0;
    if (isHot && !told(k).isHot)
        deviceLog().warn("{}: unit {} is hot; its fan should run", _name, k);
    told(k).isHot = isHot;
    return (state & FAILSAFE) != 0;
}

void UnitWatch::watchClocks(double now_s)
{
    for (int k = 0; k < _group.size(); ++k)
    {
        const Unit& unit = _group.unit(k);
        const bool isOut = unit.isThere() && unit.outOfStep_s > 0;
        if (isOut && !told(k).isOutOfStep)
            deviceLog().warn("{}: unit {} doesn't follow the units' clock", _name, k);
        told(k).isOutOfStep = isOut;
        if (isOut && now_s - unit.outOfStep_s > kOutOfStep_s)
            _group.lose(k, fmt::format("didn't follow the clock for {:g} s", kOutOfStep_s));
    }
}

std::string UnitWatch::losses(double now_s)
{
    if (!_group.findLost(now_s)) return {};
    std::string why;
    for (int k = 0; k < _group.size(); ++k)
    {
        const bool isLost = !_group.isThere(k);
        if (isLost && !told(k).isLost)
            why += fmt::format("{}unit {} {}", why.empty() ? "" : ", ", k, _group.unit(k).lost);
        told(k).isLost = isLost;
    }
    return why;
}

std::vector<bool> UnitWatch::lost() const
{
    std::vector<bool> lost;
    for (const Told& one : _told)
        lost.push_back(one.isLost);
    return lost;
}

std::string UnitWatch::complaint() const
{
    std::string text;
    const auto add = [&](int k, const std::string& what)
    { text += fmt::format("{}unit {} {}", text.empty() ? "" : ", ", k, what); };
    for (int k = 0; k < _group.size(); ++k)
        if (!_group.isThere(k))
            add(k, _group.unit(k).lost);
        else if (_told[static_cast<std::size_t>(k)].isOutOfStep)
            add(k, "doesn't follow the clock");
        else if (_told[static_cast<std::size_t>(k)].isHot)
            add(k, "is hot");
    return text;
}

// Reopening assigns all ids again and silences all units: it must not happen each time a loose plug
// moves.
std::string UnitWatch::returns(double now_s)
{
    if (_group.count() == _group.size() || now_s - _looking.last_s < kLookForLost_s) return {};
    _looking.last_s = now_s;
    if (!_looking.found.empty() && now_s - _looking.opened_s > kLeastReopen_s)
        return _looking.found;
    _looking.number = _group.unit(0).queue.nextMessage();
    _group.link().sendToGroup(message(Kind::READ_UNIT_INFO, _looking.number));
    return {};
}

void UnitWatch::takeInfo(const Endpoint& from, const Answer& answer)
{
    const bool isAsked = answer.kind == Kind::READ_UNIT_INFO && answer.number == _looking.number &&
                         answer.version == kProtocolVersion && answer.status == 0;
    if (!isAsked)
        return _refusals.add(
            Refusal::STRAY, endpointText(from) + " wasn't asked", _group.link().now_s());
    const int id = answer.info.id;
    if (id == kNoId)
        _looking.found = "a unit without id has appeared";
    else if (id < _group.size() && !_group.isThere(id) && _group.unit(id).at == from)
        _looking.found = fmt::format("unit {} is back", id);
    else
        return;
    _looking.found += ": all units are reopened";
}

Autd3Session::Autd3Session(std::shared_ptr<DatagramLink> link,
                           const Autd3Options& options,
                           const std::string& name,
                           Refusals& refusals,
                           Autd3Account& account,
                           bool isBack) :
    _options(options),
    _name(name),
    _refusals(refusals),
    _account(account),
    _link(std::move(link)),
    _group(openUnits({*_link, refusals, options, name, [&account] { return account.isClosing(); }},
                     account,
                     isBack)),
    _player(*_group, options),
    _watch(*_group, name, refusals)
{
    _rounds.looped_s = _link->now_s();
}

void Autd3Session::end(const std::string& why)
{
    const int lost = _player.cut() != nullptr ? 1 : 0;
    _account.detach(why, lost, std::exchange(_next, nullptr) != nullptr ? 1 : 0);
}

void Autd3Session::obey()
{
    Autd3Account::Orders orders;
    if (!_account.takeOrders(orders)) return;
    if (orders.silence)
    {
        _account.noteDropped(_player.silence());
        _account.noteDropped(std::exchange(_next, nullptr));
        _silence_s = orders.silence_s;
    }
    if (orders.job == nullptr) return;
    if (!orders.job->isSequence()) _account.noteDropped(_player.abandonSequence());
    _account.noteDropped(std::exchange(_next, std::move(orders.job)));
    _tries = 0;
}

void Autd3Session::startNext()
{
    if (_next != nullptr && _player.isReady()) _player.start(std::exchange(_next, nullptr));
}

void Autd3Session::settle(const BankPlayer::Ending& ending)
{
    const bool isDisturbed = ending.fate == BankPlayer::Fate::DISTURBED;
    if (isDisturbed)
    {
        if (_next != nullptr) return _account.noteDropped(ending.job); // a newer one waits
        if (++_tries < kMostTries)
        {
            _next = ending.job;
            return;
        }
    }
    if (ending.fate != BankPlayer::Fate::PLAYED)
        return _account.tell(
            [&](Autd3Account::Told& told)
            {
                ++told.report.lost;
                told.countFault(isDisturbed ? fmt::format("a field came too late for a unit {} "
                                                          "times; set lead to more than {:g} ms",
                                                          kMostTries,
                                                          _options.lead_s * 1e3)
                                            : told.report.message);
            });
    _tries = 0;
    _account.notePlayed(ending.job,
                        ending.handedOver_s,
                        _group->clock().at_ns(ending.handedOver_s) - ending.handedOver_s * 1e9);
}

void Autd3Session::settleEndings()
{
    for (const BankPlayer::Ending& ending : _player.takeEndings())
        settle(ending);
    const std::string fault = _player.takeFault();
    if (fault.empty()) return;
    _account.noteFault(fault);
    const double now_s = _link->now_s();
    if (now_s - _rounds.faultLogged_s < kFaultLog_s) return;
    _rounds.faultLogged_s = now_s;
    deviceLog().warn("{}: {}", _name, fault);
}

void Autd3Session::takeState(const UnitGroup::Outcome& outcome)
{
    if (!_watch.takeState(outcome)) return;
    const std::string what = fmt::format(
        "unit {} was silenced by its fail-safe; silent until the next field", outcome.unit);
    deviceLog().warn("{}: {}", _name, what);
    _account.noteDropped(_player.release(outcome.unit));
    _account.tell(
        [&](Autd3Account::Told& told)
        {
            told.countFault(what);
            ++told.report.silences;
            told.playing.job = nullptr;
        });
}

void Autd3Session::takeOutcomes(double now_s)
{
    for (const UnitGroup::Outcome& outcome : _group->takeOutcomes())
        if (outcome.done.code == kReadFpgaStateCode)
            takeState(outcome);
        else
            _player.take(outcome);
    _player.step(now_s);
    settleEndings();
    if (_silence_s > 0 && _player.isSilent())
        _account.tell([this](Autd3Account::Told& told)
                      { told.confirm(std::exchange(_silence_s, 0)); });
}

// Only heartbeats are in flight, whose answers can wait for the next ones: the thread then wakes
// once for all of them.
void Autd3Session::receive(double now_s)
{
    const double until_s = std::min(_group->due_s(), _player.due_s());
    const bool isQuiet = _player.isReady() && _next == nullptr && _group->isIdle();
    const double prompt_s = _group->isResting() ? kPromptAtRest_s : kPrompt_s;
    if (!isQuiet || now_s - _rounds.heardPromptly_s > prompt_s)
    {
        _group->receive(until_s);
        if (isQuiet && _link->now_s() >= until_s) _rounds.heardPromptly_s = now_s;
        return;
    }
    _link->rest(until_s);
    _group->receive(0, false);
}

void Autd3Session::publish(double now_s)
{
    if (now_s - _rounds.published_s < kPublish_s) return;
    _rounds.published_s = now_s;
    _watch.watchClocks(now_s);
    _account.tell(
        [&](Autd3Account::Told& told)
        {
            told.report.complaint = _watch.complaint();
            told.refusals = _refusals.text();
            told.figures = {threadCpu_s(),
                            _group->repeats(),
                            _player.takenBack(),
                            _player.torn(),
                            _refusals.total(),
                            _player.lead_s()};
        });
}

std::string Autd3Session::losses(double now_s)
{
    std::string why = _watch.losses(now_s);
    if (why.empty()) return {};
    _account.tell([&](Autd3Account::Told& told) { told.playing.isLost = _watch.lost(); });
    if (_options.whenLost == WhenLost::ALL_FALL_SILENT || _group->count() == 0) return why;
    _account.noteFault(why);
    deviceLog().error("{}: {}; the others play on", _name, why);
    return {};
}

void Autd3Session::sayFarewell()
{
    _account.noteDropped(_player.silence());
    const double atMost_s = _account.isClosing() ? kFarewell_s : kLastMask_s;
    const double until_s = _link->now_s() + atMost_s;
    for (double now_s = 0; now_s < until_s && !_player.isSilent();)
    {
        now_s = _link->now_s();
        _group->pump(now_s);
        _group->receive(std::min(until_s, _group->due_s()));
        takeOutcomes(now_s);
        _group->findLost(now_s);
    }
}

std::string Autd3Session::play()
{
    for (;;)
    {
        double now_s = _link->now_s();
        if (_account.isClosing())
        {
            sayFarewell();
            return {};
        }
        // After such a pause units may have fallen silent, and nothing else reports it.
        const bool wasStopped = now_s - _rounds.looped_s > _options.failsafe_s / 2;
        if (wasStopped) _group->forgive(now_s);
        _watch.askStates(now_s, wasStopped);
        _rounds.looped_s = now_s;
        obey();
        startNext();
        _player.step(now_s);
        _group->pump(now_s);
        receive(now_s);
        now_s = _link->now_s();
        takeOutcomes(now_s);
        startNext();
        _group->pump(now_s);
        std::string why = losses(now_s);
        if (why.empty()) why = _watch.returns(now_s);
        if (!why.empty())
        {
            sayFarewell();
            return why;
        }
        publish(now_s);
    }
}

} // namespace midair::device::autd3
