#include "device/DeviceLog.h"
#include "device/autd3/Autd3Device.h"
#include "device/autd3/UdpLink.h"

#include <algorithm>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

// How the thread of an Autd3Device keeps an eye on its units.
namespace midair::device::autd3
{

namespace
{

constexpr double kStates_s = 1; // how often each unit is asked for its state
constexpr double kOutOfStep_s = 2;
constexpr double kLookForLost_s = 0.5; // how often
constexpr double kLeastReopen_s = 10;  // from one opening of all for a lost unit to the next

} // namespace

// One unit after the other, so that fields don't wait for sixteen answers at once; at rest all at
// once, so that the thread wakes once.
void Autd3Device::askStates(double now_s, bool all)
{
    if (!all && _group->isResting())
    {
        if (now_s - _asked_s < kStates_s) return;
        _asked_s = now_s;
        all = true;
    }
    if (all)
        for (int k = 0; k < _group->size(); ++k)
            _group->push(k, Command::readFpgaState());
    const double step_s = kStates_s / _group->size();
    while (now_s - _asked_s >= step_s)
    {
        _asked_s = std::max(_asked_s + step_s, now_s - kStates_s);
        _askNext = (_askNext + 1) % _group->size();
        if (!all) _group->push(_askNext, Command::readFpgaState());
    }
}

void Autd3Device::watch(const UnitGroup::Outcome& outcome)
{
    const int k = outcome.unit;
    if (!outcome.done.result) _group->push(k, Command::readFpgaState()); // its answer was lost
    if (outcome.done.data.size() != 1) return;
    const std::uint8_t state = outcome.done.data.front();
    const bool isHot = (state & IS_HOT) != 0;
    if (isHot && !_isHot[static_cast<std::size_t>(k)])
        deviceLog().warn("{}: unit {} is hot; its fan should run", _name, k);
    _isHot[static_cast<std::size_t>(k)] = isHot;
    if ((state & FAILSAFE) == 0) return;
    const std::string what =
        fmt::format("unit {} was silenced by its fail-safe; silent until the next field", k);
    deviceLog().warn("{}: {}", _name, what);
    drop(_player->release(k));
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_report.faults;
    _report.message = what;
    ++_report.silences;
    _playing.job = nullptr;
}

void Autd3Device::watchClocks(double now_s)
{
    for (int k = 0; k < _group->size(); ++k)
    {
        const Unit& unit = _group->unit(k);
        const bool isOut = unit.isThere() && unit.outOfStep_s > 0;
        if (isOut && !_isOutOfStep[static_cast<std::size_t>(k)])
            deviceLog().warn("{}: unit {} doesn't follow the units' clock", _name, k);
        _isOutOfStep[static_cast<std::size_t>(k)] = isOut;
        if (isOut && now_s - unit.outOfStep_s > kOutOfStep_s)
            _group->lose(k, fmt::format("didn't follow the clock for {:g} s", kOutOfStep_s));
    }
}

// Returns why all have to be opened again; empty: go on.
std::string Autd3Device::losses(double now_s)
{
    if (!_group->findLost(now_s)) return {};
    std::string why;
    const std::lock_guard<std::mutex> lock(_mutex);
    for (int k = 0; k < _group->size(); ++k)
    {
        const bool isLost = !_group->isThere(k);
        if (isLost && !_playing.isLost[static_cast<std::size_t>(k)])
            why += fmt::format("{}unit {} {}", why.empty() ? "" : ", ", k, _group->unit(k).lost);
        _playing.isLost[static_cast<std::size_t>(k)] = isLost;
    }
    if (_options.whenLost == WhenLost::ALL_FALL_SILENT || _group->count() == 0) return why;
    ++_report.faults;
    _report.message = why;
    deviceLog().error("{}: {}; the others play on", _name, why);
    return {};
}

std::string Autd3Device::complaint() const
{
    std::string text;
    const auto add = [&](int k, const std::string& what)
    { text += fmt::format("{}unit {} {}", text.empty() ? "" : ", ", k, what); };
    for (int k = 0; k < _group->size(); ++k)
        if (!_group->isThere(k))
            add(k, _group->unit(k).lost);
        else if (_isOutOfStep[static_cast<std::size_t>(k)])
            add(k, "doesn't follow the clock");
        else if (_isHot[static_cast<std::size_t>(k)])
            add(k, "is hot");
    return text;
}

// Ids are given to all anew, so all are silent for that: not for each time that a loose plug moves.
std::string Autd3Device::returns(double now_s)
{
    if (_group->count() == _group->size() || now_s - _looked_s < kLookForLost_s) return {};
    _looked_s = now_s;
    if (!_back.empty() && now_s - _opened_s > kLeastReopen_s) return _back;
    _lookNumber = _group->unit(0).queue.nextMessage();
    _group->link().sendToGroup(message(Kind::READ_UNIT_INFO, _lookNumber));
    return {};
}

void Autd3Device::takeInfo(const Endpoint& from, const Answer& answer)
{
    const bool isAsked = answer.kind == Kind::READ_UNIT_INFO && answer.number == _lookNumber &&
                         answer.version == kProtocolVersion && answer.status == 0;
    if (!isAsked)
        return _refusals.add(
            Refusal::STRAY, endpointText(from) + " wasn't asked", _group->link().now_s());
    const int id = answer.info.id;
    if (id == kNoId)
        _back = "a unit that has no id is there";
    else if (id < _group->size() && !_group->isThere(id) && _group->unit(id).at == from)
        _back = fmt::format("unit {} is there again", id);
    else
        return;
    _back += ": all are opened again";
}

} // namespace midair::device::autd3
