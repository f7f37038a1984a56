#include "device/autd3/UnitMasks.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kReleaseAgain_s = 10e-3;
constexpr double kSilentAgain_s = 10e-3;
constexpr double kRepeatMask_s = 1e-3;

} // namespace

UnitMasks::UnitMasks(UnitGroup& group, const Autd3Options& options, std::string& fault) :
    _group(group),
    _options(options),
    _fault(fault),
    _open(group),
    _isTripped(static_cast<std::size_t>(options.units))
{
}

void UnitMasks::push(int unit)
{
    const bool isOn = _state != State::LIFTING;
    _open.push(unit,
               isOn ? Command::silenceAll()
                    : Command::setOutputMask(_options.silent[static_cast<std::size_t>(unit)]),
               _group.soon_s(kRepeatMask_s));
}

void UnitMasks::pushAll()
{
    for (int k = 0; k < _group.size(); ++k)
        push(k);
}

void UnitMasks::cover()
{
    if (_state == State::ON) return;
    _state = State::ON;
    pushAll();
}

void UnitMasks::forgetLost()
{
    _open.forgetLost();
    for (int k = 0; k < _group.size(); ++k)
        if (!_group.isThere(k)) _isTripped[static_cast<std::size_t>(k)] = false;
}

void UnitMasks::take(const UnitGroup::Outcome& outcome)
{
    const int k = outcome.unit;
    if (_open.of(k) == 0) return;
    _open.settle(k);
    const bool isDone = outcome.done.result && *outcome.done.result == DONE;
    if (outcome.done.code == kReleaseCode)
    {
        if (isDone) _isTripped[static_cast<std::size_t>(k)] = false;
        if (outcome.done.result && !isDone && *outcome.done.result != FAILSAFE_LASTS)
            _fault = fmt::format(
                "unit {}: its fail-safe isn't released: {}", k, resultText(*outcome.done.result));
        return;
    }
    if (_open.of(k) > 0 || isDone) return; // a later one counts
    if (!outcome.done.result)
        push(k);
    else
        _group.lose(k, "refuses to be masked: " + resultText(*outcome.done.result));
}

void UnitMasks::noteSilentField(bool isPlayed, double now_s)
{
    const bool isWaitedFor = isPlayed && _state == State::ON;
    if (isWaitedFor) _state = State::RELEASING;
    _again_s = isWaitedFor ? now_s : now_s + kSilentAgain_s;
}

double UnitMasks::due_s() const
{
    return areSilent() ? _again_s : UnitGroup::kNever_s;
}

bool UnitMasks::step(double now_s)
{
    if (!_open.none() || now_s < _again_s) return false;
    switch (_state)
    {
    case State::OFF:
        break;
    case State::ON:
        return true;
    case State::RELEASING:
        if (std::find(_isTripped.begin(), _isTripped.end(), true) != _isTripped.end())
        {
            for (int k = 0; k < _group.size(); ++k)
                if (_isTripped[static_cast<std::size_t>(k)])
                    _open.push(k, Command::releaseFailsafe(), FrameQueue::kRepeat_s);
            _again_s = now_s + kReleaseAgain_s;
            break;
        }
        _state = State::LIFTING;
        pushAll();
        if (_open.none()) _state = State::OFF;
        break;
    case State::LIFTING:
        _state = State::OFF;
        break;
    }
    return false;
}

} // namespace midair::device::autd3
