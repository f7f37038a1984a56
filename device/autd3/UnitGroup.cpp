#include "device/autd3/UnitGroup.h"

#include "device/DeviceLog.h"
#include "device/autd3/UdpLink.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

constexpr const char* kNames[] = {
    "malformed", "foreign", "stray", "of a unit with another id", "of another protocol"};

constexpr std::uint16_t kMostBeatsOpen = 1024; ///< message numbers; frames have some of them
constexpr double kBeatAgain_s = 5e-3;          ///< after an unanswered heartbeat
constexpr double kRetry_s = 0.1e-3;            ///< before retrying a send without room
constexpr std::uint8_t kFollowsClock = HAS_SYNC_PULSE | FOLLOWS_CLOCK;
constexpr int kMostAtOnce = 256; ///< datagrams, before other work

} // namespace

void Refusals::add(Refusal refusal, const std::string& what, double now_s)
{
    Entry& entry = _entries[index(refusal)];
    ++entry.count;
    if (refusal == Refusal::STRAY) return;
    if (entry.logged > 0 && now_s - entry.logged_s < kLog_s) return;
    deviceLog().warn("{}: refused a datagram that is {}: {}; {} since the last such line",
                     _device,
                     kNames[index(refusal)],
                     what,
                     entry.count - entry.logged);
    entry.logged = entry.count;
    entry.logged_s = now_s;
}

std::uint64_t Refusals::total() const
{
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < _entries.size(); ++i)
        if (i != index(Refusal::STRAY)) sum += _entries[i].count;
    return sum;
}

std::string Refusals::text() const
{
    std::string text;
    for (std::size_t i = 0; i < _entries.size(); ++i)
        if (i != index(Refusal::STRAY) && _entries[i].count > 0)
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", _entries[i].count, kNames[i]);
    return text;
}

UnitGroup::UnitGroup(DatagramLink& link, Refusals& refusals, std::vector<Unit> units, Beats beats) :
    _link(link),
    _refusals(refusals),
    _units(std::move(units)),
    _beats(beats)
{
    forgive(_link.now_s());
}

int UnitGroup::count() const
{
    return static_cast<int>(
        std::count_if(_units.begin(), _units.end(), [](const Unit& u) { return u.isThere(); }));
}

// Reading a state doesn't count as activity.
void UnitGroup::push(int k, const Command& command, double repeat_s, int copies)
{
    if (!isThere(k)) return;
    if (command.code() != kReadFpgaStateCode) unit(k).pushed_s = _link.now_s();
    unit(k).queue.push(command, repeat_s, copies);
}

void UnitGroup::note(Unit& unit, double now_s)
{
    unit.sent_s = now_s;
    if (unit.asked++ == 0) unit.asked_s = now_s;
}

void UnitGroup::sendBeat(Unit& unit, double now_s)
{
    const std::uint16_t number = unit.queue.nextMessage();
    if (!_link.send(unit.at, message(Kind::HEARTBEAT, number))) return;
    if (!unit.isBeatOpen) unit.unanswered = number;
    unit.beat = number;
    unit.isBeatOpen = true;
    unit.beats_s[number % unit.beats_s.size()] = _link.now_s();
    note(unit, now_s);
}

bool UnitGroup::isResting(const Unit& unit)
{
    return unit.sent_s - unit.pushed_s > kResting_s;
}

// Unanswered heartbeats are repeated soon, because the fail-safe doesn't wait.
double UnitGroup::beatDue_s(const Unit& unit) const
{
    const double beat_s = isResting(unit) ? _beats.resting_s : _beats.playing_s;
    return unit.sent_s + (unit.isBeatOpen ? std::min(beat_s, kBeatAgain_s) : beat_s);
}

// The farthest unit first, because it receives last. Units at rest get their heartbeats together,
// so that the thread wakes once for all.
void UnitGroup::pump(double now_s)
{
    bool isDue = false;
    for (auto unit = _units.rbegin(); unit != _units.rend(); ++unit)
    {
        if (!unit->isThere()) continue;
        const FrameQueue::Send send = [&](const std::vector<std::uint8_t>& bytes)
        { return _link.send(unit->at, bytes); };
        if (unit->queue.pump(now_s, send)) note(*unit, now_s);
        isDue = isDue || now_s >= beatDue_s(*unit);
    }
    if (!isDue) return;
    for (auto unit = _units.rbegin(); unit != _units.rend(); ++unit)
    {
        const bool isEarly = isResting(*unit) && !unit->isBeatOpen;
        const double due_s = beatDue_s(*unit) - (isEarly ? _beats.resting_s / 2 : 0);
        if (unit->isThere() && now_s >= due_s) sendBeat(*unit, now_s);
    }
}

double UnitGroup::due_s() const
{
    double due_s = kNever_s;
    for (const Unit& unit : _units)
    {
        if (!unit.isThere()) continue;
        due_s = std::min({due_s, beatDue_s(unit), unit.queue.due_s(kNever_s)});
        if (unit.queue.unsent() > 0 && unit.queue.inFlight() < FrameQueue::kWindow)
            due_s = std::min(due_s, _link.now_s() + kRetry_s);
    }
    return due_s;
}

bool UnitGroup::isIdle() const
{
    return std::all_of(_units.begin(),
                       _units.end(),
                       [](const Unit& unit) { return !unit.isThere() || unit.queue.isIdle(); });
}

bool UnitGroup::isResting() const
{
    return std::all_of(_units.begin(),
                       _units.end(),
                       [](const Unit& unit) { return !unit.isThere() || isResting(unit); });
}

void UnitGroup::receive(double until_s, bool isPrompt)
{
    _isPrompt = isPrompt;
    Endpoint from;
    for (int i = 0; i < kMostAtOnce && _link.receive(until_s, from, _bytes); ++i)
    {
        take(from, _bytes, _link.now_s());
        until_s = 0; // only what is available
    }
}

int UnitGroup::find(const Endpoint& from) const
{
    const auto at = std::find_if(
        _units.begin(), _units.end(), [&](const Unit& unit) { return unit.at == from; });
    return at == _units.end() ? -1 : static_cast<int>(at - _units.begin());
}

void UnitGroup::take(const Endpoint& from, const std::vector<std::uint8_t>& bytes, double now_s)
{
    Answer answer;
    std::string error;
    const int k = find(from);
    if (!readAnswer(bytes, answer, error))
        _refusals.add(Refusal::MALFORMED, endpointText(from) + ": " + error, now_s);
    else if (answer.kind != Kind::FRAME && answer.kind != Kind::HEARTBEAT && _other)
        _other(from, answer);
    else if (k < 0)
        _refusals.add(Refusal::FOREIGN, endpointText(from) + " is no unit of this array", now_s);
    else if (answer.version != kProtocolVersion)
        _refusals.add(Refusal::OTHER_PROTOCOL,
                      fmt::format("{} speaks version {}, this program {}",
                                  endpointText(from),
                                  answer.version,
                                  kProtocolVersion),
                      now_s);
    else if (answer.kind != Kind::FRAME && answer.kind != Kind::HEARTBEAT)
        _refusals.add(Refusal::STRAY, "nobody asked", now_s);
    else
        takeReply(k, answer, now_s);
}

// On a long path, answers to the first of several heartbeats count as well.
bool UnitGroup::isAnswered(const Unit& unit, std::uint16_t number)
{
    const auto open = static_cast<std::uint16_t>(unit.beat - unit.unanswered);
    const bool isAny = open < kMostBeatsOpen;
    return isAny && static_cast<std::uint16_t>(number - unit.unanswered) <= open;
}

/// Returns how long a heartbeat's answer took; < 0: too long ago.
double UnitGroup::beatTook_s(const Unit& unit, std::uint16_t number, double now_s)
{
    const auto since = static_cast<std::uint16_t>(unit.beat - number);
    return since < unit.beats_s.size() ? now_s - unit.beats_s[number % unit.beats_s.size()] : -1;
}

void UnitGroup::takeReply(int k, const Answer& answer, double now_s)
{
    Unit& unit = this->unit(k);
    if (!unit.isThere()) return;
    const bool isBeat = answer.kind == Kind::HEARTBEAT;
    const bool isOpen =
        isBeat ? isAnswered(unit, answer.number) : unit.queue.isInFlight(answer.number);
    if (!isOpen) return _refusals.add(Refusal::STRAY, "a late or repeated answer", now_s);
    // If true, it stays true, and the unit is lost for not answering.
    const bool hasId = answer.status == 0 && (answer.reply.flags & HAS_ID) != 0;
    if (answer.status != 0 || !hasId || answer.reply.id != unit.id)
    {
        unit.suspicion = answer.status != 0 ? "refuses messages: " + statusText(answer.status)
                                            : "has another id, so it has restarted";
        return _refusals.add(
            Refusal::WRONG_ID,
            fmt::format("unit {} at {} {}", k, endpointText(unit.at), unit.suspicion),
            now_s);
    }
    unit.suspicion.clear();
    double took_s = -1;
    if (isBeat)
    {
        took_s = beatTook_s(unit, answer.number, now_s);
        unit.isBeatOpen = false;
        unit.unanswered = static_cast<std::uint16_t>(answer.number + 1);
    }
    _done.clear();
    if (!isBeat) unit.queue.take(answer.reply, answer.number, now_s, _done);
    for (FrameQueue::Done& done : _done)
    {
        took_s = std::max(took_s, done.took_s);
        _outcomes.push_back({k, std::move(done), answer.reply.time_ns});
    }
    unit.heard_s = now_s;
    unit.asked = 0;
    unit.flags = answer.reply.flags;
    if ((unit.flags & kFollowsClock) == kFollowsClock)
        unit.outOfStep_s = 0;
    else if (unit.outOfStep_s == 0)
        unit.outOfStep_s = now_s;
    if (_isPrompt) _clock.note(answer.reply.time_ns, now_s, took_s);
}

void UnitGroup::lose(int k, const std::string& why)
{
    Unit& unit = this->unit(k);
    if (!unit.isThere()) return;
    unit.lost = why;
    unit.queue.dropUnsent();
}

bool UnitGroup::findLost(double now_s)
{
    bool isNew = false;
    for (int k = 0; k < size(); ++k)
    {
        Unit& one = unit(k);
        if (one.isThere())
        {
            if (one.asked >= kLeastAsked && now_s - one.asked_s > kLost_s)
                lose(k, one.suspicion.empty() ? "doesn't answer" : one.suspicion);
            else if (now_s - one.queue.oldest_s(now_s) > kLost_s)
                lose(k, "answers, but ignores all commands: another program may use it");
        }
        if (!one.isThere() && !one.isLossTold) one.isLossTold = isNew = true;
    }
    return isNew;
}

void UnitGroup::forgive(double now_s)
{
    for (Unit& unit : _units)
    {
        unit.asked = 0;
        unit.queue.touch(now_s);
    }
}

double UnitGroup::soon_s(double pause_s) const
{
    constexpr double kSoon_s = 0.9 * FrameQueue::kRepeat_s;
    constexpr double kTripShare = 0.25;
    return pause_s >= kSoon_s ? pause_s : std::min(pause_s + kTripShare * _clock.trip_s(), kSoon_s);
}

std::uint64_t UnitGroup::repeats() const
{
    std::uint64_t sum = 0;
    for (const Unit& unit : _units)
        sum += unit.queue.repeats();
    return sum;
}

} // namespace midair::device::autd3
