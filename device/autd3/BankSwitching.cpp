#include "device/autd3/BankPlayer.h"

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
constexpr double kBackAfter_s = 1.5e-3; // beyond margin and round trip: time to reach all units
constexpr double kLongestBack_s = 0.2;  // a switch back that is refused is put off twice as far
constexpr int kMostBacks = 20;          // of one unit
constexpr double kTripShare = 0.25;     // of the round trip is added to pauses
constexpr double kLongestLead_s = 0.1;
constexpr double kLossy_s = 2;          // after a datagram was lost
constexpr double kMostApart_s = 1.5e-3; // of units that switch at once

// Half a period off the grid of slots, so that no unit is on the other side of its edge.
double besideEdge(double wanted_ns)
{
    return std::ceil(wanted_ns / kSlotPeriod_ns) * kSlotPeriod_ns + kSlotPeriod_ns / 2.0;
}

} // namespace

// Where datagrams are lost, a switch is sent twice: until a lost one is repeated, units differ.
int BankPlayer::switchCopies(double now_s)
{
    if (_repeats != _group.repeats()) _lossy_s = now_s;
    _repeats = _group.repeats();
    return _lossy_s >= 0 && now_s - _lossy_s < kLossy_s ? 2 : 1;
}

void BankPlayer::noteSwitch(std::uint64_t time_ns)
{
    _first_ns = std::min(_first_ns, time_ns);
    _last_ns = std::max(_last_ns, time_ns);
}

// A pause between repeats that don't wait for an answer, but aren't many where the way is long.
double BankPlayer::soon_s(double pause_s) const
{
    constexpr double kSoon_s = 0.9 * FrameQueue::kRepeat_s;
    if (pause_s >= kSoon_s) return pause_s;
    return std::min(pause_s + kTripShare * _group.clock().trip_s(), kSoon_s);
}

void BankPlayer::tellTorn(const std::string& what)
{
    if (!std::exchange(_isTorn, true)) ++_torn;
    _fault = what;
}

// The lead is for the acknowledgements, with repeats; then for taking the switch back where one is
// missing; then the units' own margin. The way takes its time beyond that: the clock is behind the
// units' by the way back, the switch takes the way there, and so does taking it back.
void BankPlayer::switchAtTime(double now_s)
{
    const double trip_s = _group.clock().trip_s();
    const double allowance_s = std::max(kLeastAllowance_s, _lead_s / 6);
    const double slack_s = std::max(kLeastSlack_s, _lead_s - _margin_s - allowance_s);
    _time_ns = besideEdge(_group.clock().at_ns(now_s + 2 * trip_s + _lead_s));
    _deadline_s = now_s + trip_s + slack_s;
    _sent_s = now_s;
    _stage = Stage::SWITCHING;
    const Command command =
        Command::activateBank(_bank, SwitchMode::AT_TIME, static_cast<std::uint64_t>(_time_ns));
    const int copies = switchCopies(now_s);
    for (int k = 0; k < _group.size(); ++k)
        push(_open, k, command, soon_s(std::max(kLeastRepeat_s, slack_s / 4)), copies);
}

void BankPlayer::switchAtOnce(double now_s)
{
    _deadline_s = kNoSwitch_s;
    _sent_s = now_s;
    if (!std::exchange(_isUnknown, false))
    {
        _first_ns = std::numeric_limits<std::uint64_t>::max();
        _last_ns = 0;
    }
    _stage = Stage::SWITCHING;
    const Command command = Command::activateBank(_bank, SwitchMode::AT_ONCE);
    const int copies = switchCopies(now_s);
    for (int k = 0; k < _group.size(); ++k)
        push(_open, k, command, soon_s(kRepeatAtOnce_s), copies);
}

void BankPlayer::endSwitching(double now_s)
{
    const bool isTimed = _deadline_s < kNoSwitch_s;
    const bool isMissed = isTimed && (_isLate || _isUnknown || now_s > _deadline_s);
    if (!_open.none() && !isMissed) return;
    if (!_refusal.empty() || (isMissed && !(_open.none() && !_isLate && !_isUnknown)))
        takeBack(now_s);
    else if (isTimed)
        _stage = Stage::WAITING;
    else if (_isUnknown)
        switchAtOnce(now_s); // twice is as once
    else
    {
        const double apart_s = static_cast<double>(_last_ns - _first_ns) * 1e-9;
        if (_last_ns > _first_ns && apart_s > kMostApart_s)
            tellTorn(fmt::format("units have switched {:.1f} ms apart: a switch at once was lost, "
                                 "or came late",
                                 apart_s * 1e3));
        end(Fate::PLAYED, now_s);
    }
}

// The bank that plays is activated: that ends the wait for the other one.
void BankPlayer::takeBack(double now_s)
{
    ++_takenBack;
    const bool isTimed = _deadline_s < kNoSwitch_s;
    if (isTimed && _refusal.empty())
        _lead_s = std::min(std::max(_options.lead_s, kLongestLead_s), _lead_s * 1.5);
    if (!isTimed && _last_ns > 0) tellTorn("a switch at once was refused by some units");
    _takenBack_ns = isTimed ? _time_ns : 0;
    _time_ns = 0;
    _backs.assign(_backs.size(), 0);
    _stage = Stage::TAKING_BACK;
    for (int k = 0; k < _group.size(); ++k)
        pushTakeBack(k, now_s);
}

// It has to be there a margin before its time, by the unit's clock: so it is aimed a round trip
// further, and twice as far each time that it was too near all the same.
void BankPlayer::pushTakeBack(int unit, double now_s)
{
    int& backs = _backs[static_cast<std::size_t>(unit)];
    const std::optional<BankConfig>& config = _configs[static_cast<std::size_t>(_playing)];
    const bool isTimed = config && !config->forEver;
    double time_ns = 0;
    if (isTimed)
    {
        const double after_s =
            std::min(kLongestBack_s, std::ldexp(kBackAfter_s, std::min(backs, 10)));
        const double ahead_s = _margin_s + _group.clock().trip_s() + after_s;
        time_ns = besideEdge(std::max(_takenBack_ns, _group.clock().at_ns(now_s + ahead_s)));
    }
    _time_ns = std::max(_time_ns, time_ns);
    push(_open,
         unit,
         Command::activateBank(_playing,
                               isTimed ? SwitchMode::AT_TIME : SwitchMode::AT_ONCE,
                               static_cast<std::uint64_t>(time_ns)),
         soon_s(kLeastRepeat_s),
         2);
    ++backs;
}

/// The switch itself may be settled in this stage, too: the last one of a unit is the one back.
void BankPlayer::takeSwitchBack(const UnitGroup::Outcome& outcome)
{
    const int k = outcome.unit;
    if (_open.of(k) > 0) return;
    const std::optional<std::uint8_t>& result = outcome.done.result;
    if (result && *result == DONE)
    {
        if (_takenBack_ns > 0 && static_cast<double>(outcome.time_ns) > _takenBack_ns)
            tellTorn(fmt::format("unit {} was told too late that a switch is put off: it may have "
                                 "played its part of a field alone",
                                 k));
    }
    else if (_backs[static_cast<std::size_t>(k)] >= kMostBacks)
        _group.lose(k, "doesn't take a switch back: " + resultText(result.value_or(DONE)));
    else
        pushTakeBack(k, _group.link().now_s());
}

} // namespace midair::device::autd3
