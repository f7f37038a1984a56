#include "device/autd3/UnitWatch.h"

#include "device/DeviceLog.h"
#include "device/autd3/UdpLink.h"

#include <algorithm>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kStates_s = 1; // how often each unit is asked for its state
constexpr double kOutOfStep_s = 2;
constexpr double kLookForLost_s = 0.5; // how often
constexpr double kLeastReopen_s = 10;  // from one opening of all for a lost unit to the next

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

// One unit after the other, so that fields don't wait for sixteen answers at once; at rest all at
// once, so that the thread wakes once.
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

// Ids are given to all anew, so all are silent for that: not for each time that a loose plug moves.
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
        _looking.found = "a unit that has no id is there";
    else if (id < _group.size() && !_group.isThere(id) && _group.unit(id).at == from)
        _looking.found = fmt::format("unit {} is there again", id);
    else
        return;
    _looking.found += ": all are opened again";
}

} // namespace midair::device::autd3
