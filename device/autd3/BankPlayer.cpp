#include "device/autd3/BankPlayer.h"

#include "device/autd3/protocol/Levels.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kCalmer = 0.999;       // of the lead, with each field that was in time
constexpr double kBehindTime_s = 25e-6; // a period: a switch is done

std::shared_ptr<const Job> silentJob(int units)
{
    auto job = std::make_shared<Job>();
    job->signals.push_back(silentSignal(units * kTransducersPerUnit));
    return job;
}

} // namespace

void BankPlayer::OpenCounts::settle(int unit, int commands)
{
    count[static_cast<std::size_t>(unit)] -= commands;
    total -= static_cast<std::uint64_t>(commands);
}

// After Clear bank 0 plays its one slot, which is zero. What else it holds nobody knows, so it gets
// its settings only when it doesn't play.
BankPlayer::BankPlayer(UnitGroup& group, const Autd3Options& options) :
    _group(group),
    _options(options),
    _margin_s(options.cpu().switchMargin_ns * 1e-9),
    _silentJob(silentJob(options.units)),
    _written(static_cast<std::size_t>(options.units)),
    _configs{BankConfig{}, std::nullopt},
    _patterns(kMostPhaseSlots),
    _lead_s(options.lead_s),
    _backs(static_cast<std::size_t>(options.units)),
    _isTripped(static_cast<std::size_t>(options.units))
{
}

void BankPlayer::push(
    OpenCounts& counts, int unit, const Command& command, double repeat_s, int copies)
{
    if (!_group.isThere(unit)) return;
    _group.push(unit, command, repeat_s, copies);
    counts.add(unit);
}

void BankPlayer::begin(std::shared_ptr<const Job> job)
{
    _job = std::move(job);
    _bank = 1 - _playing;
    _isCut = _isUnknown = _isLate = _isTorn = false;
    _refusal.clear();
    BankConfig config;
    if (_job->isSequence())
        config = {_job->divider, static_cast<int>(_job->signals.size()), true};
    else if (_options.timed)
        config = {1, 2, false};
    _slots = config.slots;
    _stage = Stage::WRITING;
    _written.assign(_written.size(), {});
    configure(config);
    feed();
}

void BankPlayer::configure(const BankConfig& config)
{
    std::optional<BankConfig>& known = _configs[static_cast<std::size_t>(_bank)];
    if (known == config) return;
    for (Written& one : _written)
        one.again.push_back(kConfigPiece);
    known = config;
}

// The units' windows are kept full, and no more is encoded than they take.
void BankPlayer::feed()
{
    for (int k = 0; k < _group.size(); ++k)
    {
        const FrameQueue& queue = _group.unit(k).queue;
        while (_group.isThere(k) && queue.unsent() + queue.inFlight() < FrameQueue::kWindow &&
               feed(k))
        {
        }
    }
}

bool BankPlayer::feed(int unit)
{
    Written& written = _written[static_cast<std::size_t>(unit)];
    int first = written.next;
    if (!written.again.empty())
    {
        first = written.again.back();
        written.again.pop_back();
    }
    else if (first == _slots)
        return false;
    if (first == kConfigPiece)
        push(_open,
             unit,
             Command::configureBank(_bank, *_configs[static_cast<std::size_t>(_bank)]),
             FrameQueue::kRepeat_s);
    else
    {
        int count = 0;
        const Command command = piece(unit, first, count);
        push(_open, unit, command, FrameQueue::kRepeat_s);
        written.next = std::max(written.next, first + count);
    }
    written.sent.push_back(first);
    return true;
}

bool BankPlayer::isWritten() const
{
    if (!_open.none()) return false;
    for (int k = 0; k < _group.size(); ++k)
    {
        const Written& written = _written[static_cast<std::size_t>(k)];
        if (_group.isThere(k) && (written.next < _slots || !written.again.empty())) return false;
    }
    return true;
}

/// As many slots as one frame takes, from \a first on; a field that stands fills them all.
Command BankPlayer::piece(int unit, int first, int& count)
{
    const int begin = _options.order[static_cast<std::size_t>(unit)] * kTransducersPerUnit;
    const auto signal = [&](int slot) -> const DriveSignal&
    { return _job->signals[_job->isSequence() ? static_cast<std::size_t>(slot) : 0]; };
    const int most = std::min(kMostPhaseSlots, _slots - first);
    std::vector<const UnitPattern*> slots;
    bool isEven = true;
    for (int i = 0; i < most && (isEven || i < kMostRawSlots); ++i)
    {
        UnitPattern& pattern = _patterns[static_cast<std::size_t>(i)];
        toUnit(signal(first + i), begin, pattern);
        const bool fits =
            pattern.isEven() && pattern.intensity.front() == _patterns.front().intensity.front();
        if (!fits && isEven && i >= kMostRawSlots) break; // the even ones before go together
        isEven = isEven && fits;
        slots.push_back(&pattern);
    }
    count = static_cast<int>(slots.size());
    return isEven ? Command::writePhases(_bank, first, _patterns.front().intensity.front(), slots)
                  : Command::writeRaw(_bank, first, slots);
}

std::shared_ptr<const Job> BankPlayer::cut()
{
    if (_stage == Stage::WRITING)
    {
        for (int k = 0; k < _group.size(); ++k)
            if (_group.isThere(k)) _open.settle(k, _group.unit(k).queue.dropUnsentWrites());
        _configs[static_cast<std::size_t>(_bank)].reset(); // its settings may be among them
    }
    _isCut = true;
    const std::shared_ptr<const Job> job = std::exchange(_job, nullptr);
    return job == _silentJob ? nullptr : job;
}

std::shared_ptr<const Job> BankPlayer::abandonSequence()
{
    const bool isWritten = _stage == Stage::WRITING && _job != nullptr && _job->isSequence();
    return isWritten ? cut() : nullptr;
}

void BankPlayer::end(Fate fate, double now_s)
{
    _stage = Stage::IDLE;
    if (fate == Fate::PLAYED)
    {
        _playing = _bank;
        _lead_s = std::max(_options.lead_s, _lead_s * kCalmer);
    }
    const std::shared_ptr<const Job> job = std::exchange(_job, nullptr);
    if (job == nullptr) return;
    if (job != _silentJob)
        _endings.push_back({job, fate, _sent_s});
    else if (fate == Fate::PLAYED && _mask == Mask::ON)
    {
        _mask = Mask::RELEASING;
        _maskAgain_s = now_s;
    }
    else
        _maskAgain_s = now_s + 10e-3;
}

void BankPlayer::forgetLost()
{
    for (int k = 0; k < _group.size(); ++k)
    {
        if (_group.isThere(k)) continue;
        _open.forget(k);
        _maskOpen.forget(k);
        _isTripped[static_cast<std::size_t>(k)] = false;
    }
}

void BankPlayer::take(const UnitGroup::Outcome& outcome)
{
    if (!_group.isThere(outcome.unit)) return;
    switch (outcome.done.code)
    {
    case kMaskCode:
    case kReleaseCode:
        return takeMasking(outcome);
    case kActivateCode:
    case kConfigureBankCode:
    case kWritePhasesCode:
    case kWriteRawCode:
        return takeStaged(outcome);
    default:
        break;
    }
}

void BankPlayer::takeStaged(const UnitGroup::Outcome& outcome)
{
    if (_open.of(outcome.unit) == 0) return;
    _open.settle(outcome.unit, 1);
    if (_stage == Stage::TAKING_BACK) return takeSwitchBack(outcome);
    // What isn't known to be there is written once more.
    if (outcome.done.code != kActivateCode)
    {
        Written& written = _written[static_cast<std::size_t>(outcome.unit)];
        if (written.sent.empty()) return;
        if (!outcome.done.result) written.again.push_back(written.sent.front());
        written.sent.pop_front();
    }
    else if (!outcome.done.result)
        _isUnknown = true;
    if (!outcome.done.result) return;
    if (outcome.done.code == kActivateCode && *outcome.done.result == TOO_NEAR)
        _isLate = true;
    else if (outcome.done.code == kActivateCode && *outcome.done.result == DONE)
        noteSwitch(outcome.time_ns);
    else if (*outcome.done.result != DONE)
        _refusal = fmt::format("unit {} refuses command {:02X}: {}",
                               outcome.unit,
                               outcome.done.code,
                               resultText(*outcome.done.result));
}

void BankPlayer::step(double now_s)
{
    forgetLost();
    stepStage(now_s);
    if (_mask != Mask::OFF) stepMask(now_s);
}

void BankPlayer::stepStage(double now_s)
{
    switch (_stage)
    {
    case Stage::IDLE:
        break;
    case Stage::WRITING:
        if (!_isCut) feed();
        if (_isCut ? _open.none() : isWritten()) endWriting(now_s);
        break;
    case Stage::SWITCHING:
        endSwitching(now_s);
        break;
    case Stage::WAITING:
        if (_group.clock().at_ns(now_s - kBehindTime_s) >= _time_ns) end(Fate::PLAYED, now_s);
        break;
    case Stage::TAKING_BACK:
        if (_open.none()) _stage = Stage::STAYING;
        break;
    case Stage::STAYING:
        if (_group.clock().at_ns(now_s - kBehindTime_s) < _time_ns) break;
        if (!_refusal.empty()) _fault = _refusal;
        end(_refusal.empty() ? Fate::DISTURBED : Fate::LOST, now_s);
        break;
    }
}

void BankPlayer::endWriting(double now_s)
{
    if (!_isCut && _refusal.empty())
    {
        _job->isSequence() || !_options.timed ? switchAtOnce(now_s) : switchAtTime(now_s);
        return;
    }
    if (!_isCut) _configs[static_cast<std::size_t>(_bank)].reset();
    if (!_refusal.empty()) _fault = _refusal;
    end(_refusal.empty() ? Fate::DISTURBED : Fate::LOST, now_s);
}

double BankPlayer::due_s() const
{
    switch (_stage)
    {
    case Stage::SWITCHING:
        return _deadline_s;
    case Stage::WAITING:
    case Stage::STAYING:
        return _group.clock().host_s(_time_ns) + kBehindTime_s;
    case Stage::IDLE:
        if (_mask != Mask::OFF && _maskOpen.none()) return _maskAgain_s;
        break;
    default:
        break;
    }
    return UnitGroup::kNever_s;
}

std::vector<BankPlayer::Ending> BankPlayer::takeEndings()
{
    return std::exchange(_endings, {});
}

std::string BankPlayer::takeFault()
{
    return std::exchange(_fault, {});
}

} // namespace midair::device::autd3
