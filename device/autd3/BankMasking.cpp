#include "device/autd3/BankPlayer.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kReleaseAgain_s = 10e-3;
constexpr double kRepeatMask_s = 1e-3;

} // namespace

void BankPlayer::pushMask(int unit)
{
    const bool isOn = _mask != Mask::LIFTING;
    push(_maskOpen,
         unit,
         isOn ? Command::silenceAll()
              : Command::setOutputMask(_options.silent[static_cast<std::size_t>(unit)]),
         soon_s(kRepeatMask_s));
}

std::shared_ptr<const Job> BankPlayer::silence()
{
    const std::shared_ptr<const Job> dropped = cut();
    if (_mask != Mask::ON)
    {
        _mask = Mask::ON;
        for (int k = 0; k < _group.size(); ++k)
            pushMask(k);
    }
    return dropped;
}

std::shared_ptr<const Job> BankPlayer::release(int unit)
{
    _isTripped[static_cast<std::size_t>(unit)] = true;
    return silence();
}

void BankPlayer::takeMasking(const UnitGroup::Outcome& outcome)
{
    const int k = outcome.unit;
    if (_maskOpen.of(k) == 0) return;
    _maskOpen.settle(k, 1);
    const bool isDone = outcome.done.result && *outcome.done.result == DONE;
    if (outcome.done.code == kReleaseCode)
    {
        if (isDone) _isTripped[static_cast<std::size_t>(k)] = false;
        if (outcome.done.result && !isDone && *outcome.done.result != FAILSAFE_LASTS)
            _fault = fmt::format(
                "unit {}: its fail-safe isn't released: {}", k, resultText(*outcome.done.result));
        return;
    }
    if (_maskOpen.of(k) > 0 || isDone) return; // a later one counts
    if (!outcome.done.result)
        pushMask(k);
    else
        _group.lose(k, "refuses to be masked: " + resultText(*outcome.done.result));
}

// Masked, it is given a silent field; when that plays on all, fail-safes are released and the masks
// are lifted, which nobody hears.
void BankPlayer::stepMask(double now_s)
{
    if (!_maskOpen.none() || _stage != Stage::IDLE || now_s < _maskAgain_s) return;
    switch (_mask)
    {
    case Mask::OFF:
        break;
    case Mask::ON:
        begin(_silentJob);
        break;
    case Mask::RELEASING:
        if (std::find(_isTripped.begin(), _isTripped.end(), true) != _isTripped.end())
        {
            for (int k = 0; k < _group.size(); ++k)
                if (_isTripped[static_cast<std::size_t>(k)])
                    push(_maskOpen, k, Command::releaseFailsafe(), FrameQueue::kRepeat_s);
            _maskAgain_s = now_s + kReleaseAgain_s;
            break;
        }
        _mask = Mask::LIFTING;
        for (int k = 0; k < _group.size(); ++k)
            pushMask(k);
        if (_maskOpen.none()) _mask = Mask::OFF;
        break;
    case Mask::LIFTING:
        _mask = Mask::OFF;
        break;
    }
}

} // namespace midair::device::autd3
