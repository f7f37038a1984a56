#include "device/autd3/Opening.h"

#include "device/autd3/UdpLink.h"
#include "device/autd3/protocol/Commands.h"

#include <algorithm>
#include <random>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr int kTries = 3;
constexpr double kAnswer_s = 0.05; // for one question
constexpr double kGroup_s = 0.2;   // for a question to all
constexpr double kForget_s = 0.1;  // for units to drop their ids and close
constexpr double kMore_s = 0.02;   // for a second answer to Discover
constexpr double kNobody_s = 3;    // without any answer
constexpr double kBooting_s = 30;  // for the next unit, if one is connected behind the last
constexpr double kLocking_s = 30;  // until all clocks are synchronised
constexpr double kLook_s = 0.05;   // polling interval for that
constexpr std::uint8_t kInStep = HAS_SYNC_PULSE | FOLLOWS_CLOCK;

// Random, so that answers to a previous session are not taken for this one's.
std::uint16_t anyNumber()
{
    return static_cast<std::uint16_t>(std::random_device{}());
}

constexpr double kSettingUp_s = 3; // for the settings of all units
constexpr int kFirmwareMajor = 0;
constexpr int kFirmwareMinor = 10;

} // namespace

Opening::Opening(DatagramLink& link,
                 Refusals& refusals,
                 const Autd3Options& options,
                 std::string device,
                 IsLeft isLeft) :
    _link(link),
    _refusals(refusals),
    _options(options),
    _device(std::move(device)),
    _isLeft(std::move(isLeft)),
    _number(anyNumber())
{
}

void Opening::take(const Endpoint& from,
                   const std::vector<std::uint8_t>& bytes,
                   const Question& question,
                   Answers& answers)
{
    const double now_s = _link.now_s();
    Answer answer;
    std::string why;
    if (!readAnswer(bytes, answer, why))
        return _refusals.add(Refusal::MALFORMED, endpointText(from) + ": " + why, now_s);
    if (answer.number != question.number || answer.kind != question.kind)
        return _refusals.add(Refusal::STRAY, "a late or repeated answer", now_s);
    // A unit's address changes with its id.
    if (question.to != nullptr && *question.to != from && question.kind != Kind::ASSIGN_ID)
        return _refusals.add(Refusal::FOREIGN, endpointText(from) + " wasn't asked", now_s);
    if (answer.version != kProtocolVersion)
        throw error(fmt::format("{} speaks protocol version {}; this program speaks {}",
                                endpointText(from),
                                answer.version,
                                kProtocolVersion));
    const bool isCopy = std::any_of(
        answers.begin(), answers.end(), [&](const auto& other) { return other.first == from; });
    if (isCopy) return _refusals.add(Refusal::STRAY, "a copy", now_s);
    answers.emplace_back(from, std::move(answer));
}

Opening::Answers Opening::ask(const Endpoint* to,
                              const std::vector<std::uint8_t>& bytes,
                              double wait_s,
                              std::size_t enough)
{
    const Question question = {
        to, static_cast<Kind>(bytes[1]), static_cast<std::uint16_t>(bytes[2] | (bytes[3] << 8))};
    const double until_s = _link.now_s() + wait_s;
    bool isSent = false;
    Answers answers;
    Endpoint from;
    std::vector<std::uint8_t> received;
    do
    {
        if (_isLeft()) throw error("closed while it was opened");
        if (!isSent) isSent = to != nullptr ? _link.send(*to, bytes) : _link.sendToGroup(bytes);
        const double now_s = _link.now_s();
        if (_link.receive(std::min(until_s, now_s + kAnswer_s), from, received))
            take(from, received, question, answers);
    } while (_link.now_s() < until_s && answers.size() < enough);
    return answers;
}

void Opening::pause(double wait_s)
{
    const double until_s = _link.now_s() + wait_s;
    Endpoint from;
    std::vector<std::uint8_t> bytes;
    while (_link.now_s() < until_s && !_isLeft())
        if (_link.receive(until_s, from, bytes))
            _refusals.add(Refusal::STRAY, "nobody asked", _link.now_s());
}

void Opening::forgetIds()
{
    ask(nullptr, message(Kind::RESET_ID, nextNumber()), kGroup_s, kMostUnits + 1);
    pause(kForget_s);
}

// A unit that missed ResetId keeps its id and doesn't answer Discover.
void Opening::resetLeftover()
{
    const Answers answers =
        ask(nullptr, message(Kind::READ_UNIT_INFO, nextNumber()), kAnswer_s, kMostUnits + 1);
    for (const auto& [from, answer] : answers)
    {
        if (answer.status != 0) continue;
        if (!isKnownFirmware(answer.info.firmware))
            throw error(unknownFirmware("the unit at " + endpointText(from), answer.info.firmware));
        const bool isOurs = std::any_of(_units.begin(),
                                        _units.end(),
                                        [&, at = from](const Unit& unit) { return unit.at == at; });
        if (answer.info.id != kNoId && !isOurs)
            ask(&from, message(Kind::RESET_ID, nextNumber()), kForget_s, 1);
    }
}

Endpoint Opening::discover(int k)
{
    const double begin_s = _link.now_s();
    const double most_s = k == 0 ? kNobody_s : kBooting_s;
    int crowds = 0;
    for (;;)
    {
        const auto question = message(Kind::DISCOVER, nextNumber());
        Answers answers = ask(nullptr, question, kForget_s, 1);
        if (answers.size() == 1)
        {
            const Answers more = ask(nullptr, message(Kind::DISCOVER, nextNumber()), kMore_s, 2);
            const bool isOne = std::all_of(more.begin(),
                                           more.end(),
                                           [&](const auto& other)
                                           { return other.first == answers.front().first; });
            if (isOne) return answers.front().first;
            if (++crowds == kTries)
                throw error("several units without id answer at once: a switch on the cable, or "
                            "several cables?");
        }
        const double waited_s = _link.now_s() - begin_s;
        if (waited_s > most_s && k == 0)
            throw error(fmt::format("no unit answers on {}: units need some seconds after "
                                    "power-on, and a firewall must let UDP from port {} in",
                                    _link.name(),
                                    kPort));
        if (waited_s > most_s)
            throw error(fmt::format("the device behind unit {} doesn't answer", k - 1));
        resetLeftover();
    }
}

/// Returns true if the unit at \a at reports the id \a k.
bool Opening::hasId(const Endpoint& at, int k)
{
    for (int i = 0; i < kTries; ++i)
        for (const auto& [from, answer] :
             ask(&at, message(Kind::READ_UNIT_INFO, nextNumber()), kAnswer_s, 1))
            if (answer.status == 0 && answer.info.id == k) return true;
    return false;
}

// Its answer may be lost, or mistaken for another's: it has then moved to its new address, and
// answers there when all are asked.
Unit Opening::assign(int k, const Endpoint& at)
{
    std::string why = "it doesn't answer";
    Unit unit;
    unit.id = static_cast<std::uint8_t>(k);
    for (int i = 0; i < kTries; ++i)
        for (const auto& [from, answer] :
             ask(&at, assignId(nextNumber(), unit.id, k == 0), kAnswer_s, 1))
        {
            unit.at = from;
            if (answer.status == 0 && hasId(from, k)) return unit;
            if (answer.status != 0) why = statusText(answer.status);
        }
    for (const auto& [from, answer] :
         ask(nullptr, message(Kind::READ_UNIT_INFO, nextNumber()), kGroup_s, kMostUnits + 1))
    {
        unit.at = from;
        if (answer.status == 0 && answer.info.id == unit.id && hasId(from, k)) return unit;
    }
    throw error(fmt::format("unit {} refuses its id: {}", k, why));
}

bool Opening::unblock(const Unit& unit)
{
    std::string why = "it doesn't answer";
    for (int i = 0; i < kTries; ++i)
    {
        const Answers answers =
            ask(&unit.at, message(Kind::UNBLOCK_DOWNSTREAM, nextNumber()), kAnswer_s, 1);
        if (answers.empty()) continue;
        if (answers.front().second.status == 0) return answers.front().second.hasDownstream;
        why = statusText(answers.front().second.status);
    }
    throw error(fmt::format("unit {} can't open the way to the next one: {}", unit.id, why));
}

void Opening::number()
{
    _units.clear();
    bool hasMore = true;
    for (int k = 0; k < _options.units; ++k)
    {
        if (!hasMore)
            throw error(fmt::format("{} units were found, but units={}", k, _options.units));
        _units.push_back(assign(k, discover(k)));
        hasMore = unblock(_units.back());
    }
    if (hasMore)
        throw error(fmt::format(
            "there are more than {} units: units={} is too few, another device is behind unit {}",
            _options.units,
            _options.units,
            _options.units - 1));
}

void Opening::checkAll()
{
    std::vector<bool> seen(_units.size());
    for (int i = 0; i < kTries; ++i)
    {
        const Answers answers =
            ask(nullptr, message(Kind::READ_UNIT_INFO, nextNumber()), kGroup_s, kMostUnits + 1);
        for (const auto& [from, answer] : answers)
        {
            if (answer.status != 0) continue;
            const std::size_t id = answer.info.id;
            if (id >= _units.size() || _units[id].at != from)
            {
                _refusals.add(Refusal::FOREIGN,
                              fmt::format("{} reports the id {}, which it was not given",
                                          endpointText(from),
                                          id),
                              _link.now_s());
                continue;
            }
            seen[id] = true;
            if (!isKnownFirmware(answer.info.firmware))
                throw error(unknownFirmware(fmt::format("unit {}", id), answer.info.firmware));
        }
        if (std::find(seen.begin(), seen.end(), false) == seen.end()) return;
    }
    const auto missing = std::find(seen.begin(), seen.end(), false) - seen.begin();
    throw error(fmt::format("unit {} has stopped answering since it got its id", missing));
}

void Opening::startClock()
{
    Answers answers;
    for (int i = 0; i < kTries && answers.empty(); ++i)
        answers = ask(&_units.front().at, setTime(nextNumber(), 0), kAnswer_s, 1);
    if (answers.empty()) throw error("unit 0 doesn't set its clock: it doesn't answer");
    if (answers.front().second.status != 0)
        throw error("unit 0 doesn't set its clock: " + statusText(answers.front().second.status));
    const double until_s = _link.now_s() + kLocking_s;
    std::vector<bool> follows(_units.size());
    while (_link.now_s() < until_s)
    {
        for (std::size_t k = 0; k < _units.size(); ++k)
        {
            if (follows[k]) continue;
            const Answers infos =
                ask(&_units[k].at, message(Kind::READ_UNIT_INFO, nextNumber()), kAnswer_s, 1);
            follows[k] = !infos.empty() && infos.front().second.status == 0 &&
                         (infos.front().second.info.flags & kInStep) == kInStep;
        }
        if (std::find(follows.begin(), follows.end(), false) == follows.end()) return;
        pause(kLook_s);
    }
    const auto one = std::find(follows.begin(), follows.end(), false) - follows.begin();
    throw error(fmt::format("unit {} doesn't follow the clock within {:g} s", one, kLocking_s));
}

std::unique_ptr<UnitGroup> Opening::open()
{
    forgetIds();
    number();
    checkAll();
    startClock();
    for (Unit& unit : _units)
        unit.queue = FrameQueue(anyNumber());
    auto group =
        std::make_unique<UnitGroup>(_link,
                                    _refusals,
                                    std::move(_units),
                                    UnitGroup::Beats{_options.heartbeat_s, _options.restBeat_s()});
    setUp(*group);
    return group;
}

bool isKnownFirmware(const FirmwareVersion& version)
{
    return version.major == kFirmwareMajor && version.minor == kFirmwareMinor;
}

std::string unknownFirmware(const std::string& who, const FirmwareVersion& version)
{
    return fmt::format("{} has firmware {}; this program supports {}.{}",
                       who,
                       version.text(),
                       kFirmwareMajor,
                       kFirmwareMinor);
}

// A unit keeps frames of a previous session and does them first.
void Opening::reset(const Unit& unit)
{
    constexpr std::uint8_t kAfterReset = 0xFF;
    const auto bytes = frame(nextNumber(), 0, Command::reset());
    for (int i = 0; i < kTries; ++i) // the same bytes: done once
    {
        const Answers answers = ask(&unit.at, bytes, kAnswer_s, 1);
        if (answers.empty()) continue;
        const Answer& answer = answers.front().second;
        if (answer.status == 0 && answer.reply.acknowledged == kAfterReset &&
            answer.reply.result == DONE && answer.reply.id == unit.id)
            return;
        throw error(fmt::format("unit {} can't be reset: {}",
                                unit.id,
                                answer.status != 0 ? statusText(answer.status)
                                                   : resultText(answer.reply.result)));
    }
    throw error(fmt::format("unit {} can't be reset: it doesn't answer", unit.id));
}

void Opening::settle(UnitGroup& group, std::vector<UnitGroup::Outcome>& outcomes)
{
    const double until_s = _link.now_s() + kSettingUp_s;
    while (!group.isIdle())
    {
        const double now_s = _link.now_s();
        if (_isLeft()) throw error("closed while it was opened");
        group.pump(now_s);
        group.receive(std::min(group.due_s(), now_s + kAnswer_s));
        for (UnitGroup::Outcome& outcome : group.takeOutcomes())
            outcomes.push_back(std::move(outcome));
        for (int k = 0; k < group.size(); ++k)
            if (!group.isThere(k))
                throw error(fmt::format("unit {} {}", k, group.unit(k).lost));
            else if (now_s > until_s && !group.unit(k).queue.isIdle())
                throw error(fmt::format("unit {} doesn't accept its settings", k));
    }
}

std::string Opening::whyNot(const UnitGroup::Outcome& outcome)
{
    FirmwareInfo info;
    if (!readFirmwareInfo(outcome.done.data, info))
        return fmt::format("unit {} doesn't report its firmware", outcome.unit);
    for (const FirmwareVersion& version : {info.cpu, info.fpga})
        if (!isKnownFirmware(version))
            return fmt::format(
                "unit {} has firmware {} (CPU) and {} (FPGA); this program supports {}.{}",
                outcome.unit,
                info.cpu.text(),
                info.fpga.text(),
                kFirmwareMajor,
                kFirmwareMinor);
    _firmware = info.cpu.text();
    return {};
}

// One command at a time, so that a unit answers repeats whatever is lost, and its result is known.
// A unit with a wrong answer is asked again.
void Opening::setAll(UnitGroup& group, const std::function<Command(int)>& command)
{
    std::string why;
    std::vector<bool> isOpen(static_cast<std::size_t>(group.size()), true);
    for (int i = 0; i < kTries; ++i)
    {
        for (int k = 0; k < group.size(); ++k)
            if (isOpen[static_cast<std::size_t>(k)]) group.push(k, command(k));
        std::vector<UnitGroup::Outcome> outcomes;
        settle(group, outcomes);
        std::fill(isOpen.begin(), isOpen.end(), false);
        for (const UnitGroup::Outcome& outcome : outcomes)
        {
            const std::uint8_t result = outcome.done.result.value_or(DONE);
            std::string wrong;
            if (!outcome.done.result)
                wrong = fmt::format("unit {} doesn't report the result of a command", outcome.unit);
            else if (result != DONE)
                wrong = fmt::format("unit {} refuses command {:02X}: {}",
                                    outcome.unit,
                                    outcome.done.code,
                                    resultText(result));
            else if (outcome.done.code == kReadFirmwareCode)
                wrong = whyNot(outcome);
            if (wrong.empty()) continue;
            why = wrong;
            isOpen[static_cast<std::size_t>(outcome.unit)] = true;
        }
        if (std::find(isOpen.begin(), isOpen.end(), true) == isOpen.end()) return;
    }
    throw error(why);
}

// Checks the firmware before changing settings.
void Opening::setUp(UnitGroup& group)
{
    for (int k = 0; k < group.size(); ++k)
        reset(group.unit(k));
    for (const Command& command : {Command::readFirmware(),
                                   Command::clear(),
                                   Command::synchronize(),
                                   Command::configureCpu(_options.cpu()),
                                   Command::setSilencer(_options.silencer),
                                   Command::setPulseWidths(dutyWidths())})
        setAll(group, [&](int) { return command; });
    setAll(group,
           [&](int k)
           { return Command::setOutputMask(_options.silent[static_cast<std::size_t>(k)]); });
}

} // namespace midair::device::autd3
