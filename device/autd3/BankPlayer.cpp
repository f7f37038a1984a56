#include "device/autd3/BankPlayer.h"

#include "device/autd3/protocol/Commands.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kReleaseAgain_s = 10e-3;
constexpr double kSilentAgain_s = 10e-3;
constexpr double kRepeatMask_s = 1e-3;

std::shared_ptr<const Job> silentJob(int units)
{
    auto job = std::make_shared<Job>();
    job->signals.push_back(silentSignal(units * kTransducersPerUnit));
    return job;
}

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

BankPlayer::BankPlayer(UnitGroup& group, const Autd3Options& options) :
    _group(group),
    _options(options),
    _silentJob(silentJob(options.units)),
    _writer(group, options, _banks),
    _switch(group, options, _banks, _fault),
    _masks(group, options, _fault)
{
}

void BankPlayer::start(std::shared_ptr<const Job> job)
{
    _job = std::move(job);
    _isCut = false;
    _refusal.clear();
    _stage = Stage::WRITING;
    _writer.begin(*_job);
}

std::shared_ptr<const Job> BankPlayer::cut()
{
    if (_stage == Stage::WRITING) _writer.cut();
    _isCut = true;
    const std::shared_ptr<const Job> job = std::exchange(_job, nullptr);
    return job == _silentJob ? nullptr : job;
}

std::shared_ptr<const Job> BankPlayer::abandonSequence()
{
    const bool isWritten = _stage == Stage::WRITING && _job != nullptr && _job->isSequence();
    return isWritten ? cut() : nullptr;
}

std::shared_ptr<const Job> BankPlayer::silence()
{
    std::shared_ptr<const Job> dropped = cut();
    _masks.cover();
    return dropped;
}

std::shared_ptr<const Job> BankPlayer::release(int unit)
{
    _masks.noteTripped(unit);
    return silence();
}

void BankPlayer::end(Fate fate, double now_s)
{
    _stage = Stage::IDLE;
    const bool isPlayed = fate == Fate::PLAYED;
    if (isPlayed)
    {
        _banks.playing = _banks.other();
        _switch.calm();
    }
    const std::shared_ptr<const Job> job = std::exchange(_job, nullptr);
    if (job == nullptr) return;
    if (job == _silentJob)
        _masks.noteSilentField(isPlayed, now_s);
    else
        _endings.push_back({job, fate, _switch.sent_s()});
}

// All units keep playing the previous field.
void BankPlayer::endRefused(double now_s)
{
    if (!_refusal.empty()) _fault = _refusal;
    end(_refusal.empty() ? Fate::DISTURBED : Fate::LOST, now_s);
}

void BankPlayer::take(const UnitGroup::Outcome& outcome)
{
    if (!_group.isThere(outcome.unit)) return;
    switch (outcome.done.code)
    {
    case kMaskCode:
    case kReleaseCode:
        return _masks.take(outcome);
    case kActivateCode:
        if (_switch.take(outcome)) noteRefusal(outcome);
        break;
    case kConfigureBankCode:
    case kWritePhasesCode:
    case kWriteRawCode:
        if (_writer.take(outcome)) noteRefusal(outcome);
        break;
    default:
        break;
    }
}

void BankPlayer::noteRefusal(const UnitGroup::Outcome& outcome)
{
    _refusal = fmt::format("unit {} refuses command {:02X}: {}",
                           outcome.unit,
                           outcome.done.code,
                           resultText(*outcome.done.result));
}

void BankPlayer::step(double now_s)
{
    _writer.forgetLost();
    _switch.forgetLost();
    _masks.forgetLost();
    stepStage(now_s);
    if (_masks.areOn() && _stage == Stage::IDLE && _masks.step(now_s)) start(_silentJob);
}

void BankPlayer::stepStage(double now_s)
{
    switch (_stage)
    {
    case Stage::IDLE:
        break;
    case Stage::WRITING:
        if (!_isCut) _writer.feed(*_job);
        if (_isCut ? !_writer.isSettled() : !_writer.isWritten()) break;
        if (!_isCut && _refusal.empty())
        {
            _switch.start(!_job->isSequence() && _options.timed, now_s);
            _stage = Stage::SWITCHING;
            break;
        }
        if (!_isCut) _banks.config(_banks.other()).reset();
        endRefused(now_s);
        break;
    case Stage::SWITCHING:
        switch (_switch.look(!_refusal.empty(), now_s))
        {
        case BankSwitch::Stand::OPEN:
            break;
        case BankSwitch::Stand::AGREED:
            _stage = Stage::WAITING;
            break;
        case BankSwitch::Stand::DONE:
            end(Fate::PLAYED, now_s);
            break;
        case BankSwitch::Stand::PUT_BACK:
            _stage = Stage::TAKING_BACK;
            break;
        }
        break;
    case Stage::WAITING:
        if (_switch.isPast(now_s)) end(Fate::PLAYED, now_s);
        break;
    case Stage::TAKING_BACK:
        if (_switch.isSettled()) _stage = Stage::STAYING;
        break;
    case Stage::STAYING:
        if (_switch.isPast(now_s)) endRefused(now_s);
        break;
    }
}

double BankPlayer::due_s() const
{
    switch (_stage)
    {
    case Stage::SWITCHING:
        return _switch.deadline_s();
    case Stage::WAITING:
    case Stage::STAYING:
        return _switch.past_s();
    case Stage::IDLE:
        return _masks.due_s();
    default:
        return UnitGroup::kNever_s;
    }
}

} // namespace midair::device::autd3
