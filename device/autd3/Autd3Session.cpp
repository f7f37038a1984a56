#include "device/autd3/Autd3Session.h"

#include "device/DeviceLog.h"
#include "device/autd3/Opening.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

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

std::unique_ptr<UnitGroup> openUnits(Opening opening, Autd3Account& account, bool isBack)
{
    std::unique_ptr<UnitGroup> group = opening.open();
    account.noteReady(opening.firmware(), isBack);
    return group;
}

} // namespace

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
        return _account.noteLost(
            isDisturbed ? fmt::format("a field came too late for some unit {} times; a longer "
                                      "lead than {:g} ms would help",
                                      kMostTries,
                                      _options.lead_s * 1e3)
                        : std::string());
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
    _account.noteFailsafe(what);
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
    if (_silence_s > 0 && _player.isSilent()) _account.noteConfirmed(std::exchange(_silence_s, 0));
}

// Nothing is on its way but heartbeats, whose answers can wait for the next ones: then the thread
// wakes once for all of them.
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
    _account.publish(_watch.complaint(),
                     _refusals.text(),
                     {threadCpu_s(),
                      _group->repeats(),
                      _player.takenBack(),
                      _player.torn(),
                      _refusals.total(),
                      _player.lead_s()});
}

std::string Autd3Session::losses(double now_s)
{
    std::string why = _watch.losses(now_s);
    if (why.empty()) return {};
    _account.noteLostUnits(_watch.lost());
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
        // Stopped for so long, units may have fallen silent, and nobody else tells.
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
