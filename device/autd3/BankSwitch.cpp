#include "device/autd3/BankSwitch.h"

#include "device/autd3/protocol/Commands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kNoSwitch_s = std::numeric_limits<double>::max();
constexpr double kRepeatAtOnce_s = 0.3e-3;
constexpr double kLeastRepeat_s = 0.15e-3;
constexpr double kLeastSlack_s = 0.1e-3;
constexpr double kLeastAllowance_s = 0.2e-3;
constexpr double kBackAfter_s = 1.5e-3; // in addition to margin and round trip: time to reach all
                                        // units
constexpr double kLongestBack_s = 0.2;  // a refused switch back is delayed twice as far
constexpr int kMostBacks = 20;          // per unit
constexpr double kLongestLead_s = 0.1;
constexpr double kCalmer = 0.999;       // factor on the lead for each field in time
constexpr double kBehindTime_s = 25e-6; // a period after its time, a switch is done
constexpr double kLossy_s = 2;          // after a lost datagram
constexpr double kMostApart_s = 1.5e-3; // between units that switch at once

// Half a period off the slot grid, so that no unit is on the other side of an edge.
double besideEdge(double wanted_ns)
{
    return std::ceil(wanted_ns / kSlotPeriod_ns) * kSlotPeriod_ns + kSlotPeriod_ns / 2.0;
}

} // namespace

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

/// As many slots as fit into a frame, from \a first on; a held field fills them all.
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
        if (!fits && isEven && i >= kMostRawSlots) break; // the equal ones before are sent together
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

BankSwitch::BankSwitch(UnitGroup& group,
                       const Autd3Options& options,
                       Banks& banks,
                       std::string& fault) :
    _group(group),
    _options(options),
    _banks(banks),
    _fault(fault),
    _margin_s(options.cpu().switchMargin_ns * 1e-9),
    _open(group),
    _back{0, std::vector<int>(static_cast<std::size_t>(options.units))},
    _lead_s(options.lead_s)
{
}

// If datagrams are lost, a switch is sent twice: units differ until a lost one is repeated.
int BankSwitch::copies(double now_s)
{
    if (_repeats != _group.repeats()) _lossy_s = now_s;
    _repeats = _group.repeats();
    return _lossy_s >= 0 && now_s - _lossy_s < kLossy_s ? 2 : 1;
}

void BankSwitch::tellTorn(const std::string& what)
{
    if (!std::exchange(_try.isTorn, true)) ++_torn;
    _fault = what;
}

void BankSwitch::calm()
{
    _lead_s = std::max(_options.lead_s, _lead_s * kCalmer);
}

bool BankSwitch::isTimed() const
{
    return _try.deadline_s < kNoSwitch_s;
}

bool BankSwitch::isPast(double now_s) const
{
    return _group.clock().at_ns(now_s - kBehindTime_s) >= _try.time_ns;
}

double BankSwitch::past_s() const
{
    return _group.clock().host_s(_try.time_ns) + kBehindTime_s;
}

void BankSwitch::start(bool atTime, double now_s)
{
    _try = {};
    if (atTime) return startAtTime(now_s);
    _try.first_ns = std::numeric_limits<std::uint64_t>::max();
    sendAtOnce(now_s);
}

// The lead covers the acknowledgements with repeats, a possible switch back, and the units' own
// margin. Travel times are added: the clock lags the units' by the return path, and both the switch
// and the switch back take the way there.
void BankSwitch::startAtTime(double now_s)
{
    const double trip_s = _group.clock().trip_s();
    const double allowance_s = std::max(kLeastAllowance_s, _lead_s / 6);
    const double slack_s = std::max(kLeastSlack_s, _lead_s - _margin_s - allowance_s);
    _try.time_ns = besideEdge(_group.clock().at_ns(now_s + 2 * trip_s + _lead_s));
    _try.deadline_s = now_s + trip_s + slack_s;
    _try.sent_s = now_s;
    const Command command = Command::activateBank(
        _banks.other(), SwitchMode::AT_TIME, static_cast<std::uint64_t>(_try.time_ns));
    const int times = copies(now_s);
    for (int k = 0; k < _group.size(); ++k)
        _open.push(k, command, _group.soon_s(std::max(kLeastRepeat_s, slack_s / 4)), times);
}

void BankSwitch::sendAtOnce(double now_s)
{
    _try.deadline_s = kNoSwitch_s;
    _try.sent_s = now_s;
    _try.isUnknown = false;
    const Command command = Command::activateBank(_banks.other(), SwitchMode::AT_ONCE);
    const int times = copies(now_s);
    for (int k = 0; k < _group.size(); ++k)
        _open.push(k, command, _group.soon_s(kRepeatAtOnce_s), times);
}

BankSwitch::Stand BankSwitch::look(bool isRefused, double now_s)
{
    const bool isUnsure = _try.isLate || _try.isUnknown;
    const bool isMissed = isTimed() && (isUnsure || now_s > _try.deadline_s);
    if (!_open.none() && !isMissed) return Stand::OPEN;
    if (isRefused || (isMissed && (!_open.none() || isUnsure)))
    {
        takeBack(isRefused, now_s);
        return Stand::PUT_BACK;
    }
    if (isTimed()) return Stand::AGREED;
    if (_try.isUnknown)
    {
        sendAtOnce(now_s); // a repeated switch has no further effect
        return Stand::OPEN;
    }
    const double apart_s = static_cast<double>(_try.last_ns - _try.first_ns) * 1e-9;
    if (_try.last_ns > _try.first_ns && apart_s > kMostApart_s)
        tellTorn(fmt::format("units have switched {:.1f} ms apart: a switch at once was lost, "
                             "or came late",
                             apart_s * 1e3));
    return Stand::DONE;
}

// Activates the playing bank, which ends the wait for the other one.
void BankSwitch::takeBack(bool isRefused, double now_s)
{
    ++_takenBack;
    if (isTimed() && !isRefused)
        _lead_s = std::min(std::max(_options.lead_s, kLongestLead_s), _lead_s * 1.5);
    if (!isTimed() && _try.last_ns > 0) tellTorn("a switch at once was refused by some units");
    _back.of_ns = isTimed() ? _try.time_ns : 0;
    _back.sent.assign(_back.sent.size(), 0);
    _try.time_ns = 0;
    _try.isBack = true;
    for (int k = 0; k < _group.size(); ++k)
        pushBack(k, now_s);
}

// It must arrive a margin before its time, by the unit's clock: so it is aimed a round trip later,
// and twice as far after each refusal as too close.
void BankSwitch::pushBack(int unit, double now_s)
{
    int& sent = _back.sent[static_cast<std::size_t>(unit)];
    const std::optional<BankConfig>& config = _banks.config(_banks.playing);
    const bool isOnce = config && !config->forEver;
    double time_ns = 0;
    if (isOnce)
    {
        const double after_s =
            std::min(kLongestBack_s, std::ldexp(kBackAfter_s, std::min(sent, 10)));
        const double ahead_s = _margin_s + _group.clock().trip_s() + after_s;
        time_ns = besideEdge(std::max(_back.of_ns, _group.clock().at_ns(now_s + ahead_s)));
    }
    _try.time_ns = std::max(_try.time_ns, time_ns);
    _open.push(unit,
               Command::activateBank(_banks.playing,
                                     isOnce ? SwitchMode::AT_TIME : SwitchMode::AT_ONCE,
                                     static_cast<std::uint64_t>(time_ns)),
               _group.soon_s(kLeastRepeat_s),
               2);
    ++sent;
}

bool BankSwitch::take(const UnitGroup::Outcome& outcome)
{
    if (_open.of(outcome.unit) == 0) return false;
    _open.settle(outcome.unit);
    if (_try.isBack)
    {
        takeOneBack(outcome);
        return false;
    }
    const std::optional<std::uint8_t>& result = outcome.done.result;
    if (!result)
        _try.isUnknown = true;
    else if (*result == TOO_NEAR)
        _try.isLate = true;
    else if (*result == DONE)
    {
        _try.first_ns = std::min(_try.first_ns, outcome.time_ns);
        _try.last_ns = std::max(_try.last_ns, outcome.time_ns);
    }
    else
        return true;
    return false;
}

/// The switch itself may be settled now as well: a unit's last one is the switch back.
void BankSwitch::takeOneBack(const UnitGroup::Outcome& outcome)
{
    const int k = outcome.unit;
    if (_open.of(k) > 0) return;
    const std::optional<std::uint8_t>& result = outcome.done.result;
    if (result && *result == DONE)
    {
        if (_back.of_ns > 0 && static_cast<double>(outcome.time_ns) > _back.of_ns)
            tellTorn(fmt::format("unit {} was told too late that a switch is cancelled: it may "
                                 "have played its part of a field alone",
                                 k));
    }
    else if (_back.sent[static_cast<std::size_t>(k)] >= kMostBacks)
        _group.lose(k, "refuses to cancel a switch: " + resultText(result.value_or(DONE)));
    else
        pushBack(k, _group.link().now_s());
}

} // namespace midair::device::autd3
