#include "device/autd3/BankWriter.h"

#include "device/autd3/protocol/Levels.h"

#include <algorithm>

namespace midair::device::autd3
{

void OpenCommands::push(int unit, const Command& command, double repeat_s, int copies)
{
    if (!_group.isThere(unit)) return;
    _group.push(unit, command, repeat_s, copies);
    ++_count[static_cast<std::size_t>(unit)];
    ++_total;
}

void OpenCommands::settle(int unit, int commands)
{
    _count[static_cast<std::size_t>(unit)] -= commands;
    _total -= static_cast<std::uint64_t>(commands);
}

void OpenCommands::forgetLost()
{
    for (int k = 0; k < _group.size(); ++k)
        if (!_group.isThere(k)) settle(k, of(k));
}

BankWriter::BankWriter(UnitGroup& group, const Autd3Options& options, Banks& banks) :
    _group(group),
    _options(options),
    _banks(banks),
    _open(group),
    _written(static_cast<std::size_t>(options.units)),
    _patterns(kMostPhaseSlots)
{
}

void BankWriter::begin(const Job& job)
{
    BankConfig config;
    if (job.isSequence())
        config = {job.divider, static_cast<int>(job.signals.size()), true};
    else if (_options.timed)
        config = {1, 2, false};
    _slots = config.slots;
    _written.assign(_written.size(), {});
    std::optional<BankConfig>& known = _banks.config(_banks.other());
    if (known != config)
    {
        for (Written& one : _written)
            one.again.push_back(kConfigPiece);
        known = config;
    }
    feed(job);
}

void BankWriter::feed(const Job& job)
{
    for (int k = 0; k < _group.size(); ++k)
    {
        const FrameQueue& queue = _group.unit(k).queue;
        while (_group.isThere(k) && queue.unsent() + queue.inFlight() < FrameQueue::kWindow &&
               feed(k, job))
        {
        }
    }
}

bool BankWriter::feed(int unit, const Job& job)
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
        _open.push(unit,
                   Command::configureBank(_banks.other(), *_banks.config(_banks.other())),
                   FrameQueue::kRepeat_s);
    else
    {
        int count = 0;
        const Command command = piece(unit, job, first, count);
        _open.push(unit, command, FrameQueue::kRepeat_s);
        written.next = std::max(written.next, first + count);
    }
    written.sent.push_back(first);
    return true;
}

bool BankWriter::isWritten() const
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
Command BankWriter::piece(int unit, const Job& job, int first, int& count)
{
    const int begin = _options.order[static_cast<std::size_t>(unit)] * kTransducersPerUnit;
    const auto signal = [&](int slot) -> const DriveSignal&
    { return job.signals[job.isSequence() ? static_cast<std::size_t>(slot) : 0]; };
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
    const int bank = _banks.other();
    return isEven ? Command::writePhases(bank, first, _patterns.front().intensity.front(), slots)
                  : Command::writeRaw(bank, first, slots);
}

void BankWriter::cut()
{
    for (int k = 0; k < _group.size(); ++k)
        if (_group.isThere(k)) _open.settle(k, _group.unit(k).queue.dropUnsentWrites());
    _banks.config(_banks.other()).reset(); // its settings may be among them
}

bool BankWriter::take(const UnitGroup::Outcome& outcome)
{
    if (_open.of(outcome.unit) == 0) return false;
    _open.settle(outcome.unit);
    Written& written = _written[static_cast<std::size_t>(outcome.unit)];
    if (written.sent.empty()) return false;
    const std::optional<std::uint8_t>& result = outcome.done.result;
    if (!result) written.again.push_back(written.sent.front());
    written.sent.pop_front();
    return result && *result != DONE;
}

} // namespace midair::device::autd3
