#include "device/autd3/emulator/unit/EmulatedUnit.h"

#include <algorithm>
#include <iterator>

namespace midair::device::emulation
{

namespace
{

enum Kind : std::uint8_t
{
    FRAME = 0,
    READ_UNIT_INFO = 1,
    RESET_ID = 2,
    DISCOVER = 3,
    ASSIGN_ID = 4,
    UNBLOCK_DOWNSTREAM = 5,
    SET_TIME = 6,
    HEARTBEAT = 7
};

enum Status : int
{
    DONE = 0,
    OTHER_VERSION = 1,
    HAS_NO_ID = 2,
    BAD_BODY = 3,
    NOT_GRANDMASTER = 4
};

constexpr std::size_t kHeaderBytes = 4;
constexpr Time_ns kLosesId_ns = 20 * kMillisecond_ns;
constexpr std::uint64_t kMostSeconds = UINT32_MAX; // of a clock
constexpr int kPortUnknown = 0xFF;
constexpr int kUpstreamPort = 0;
constexpr std::uint8_t kReset = 0x00;
constexpr std::uint8_t kClear = 0x03;

bool isAllOff(const std::vector<std::uint8_t>& mask)
{
    for (std::size_t i = 0; i < mask.size(); ++i)
        if ((i + 1 < mask.size() ? mask[i] : mask[i] & 1U) != 0) return false;
    return true;
}

} // namespace

EmulatedUnit::EmulatedUnit(int place, const Options& options, FieldWatch& watch, Time_ns now_ns) :
    _place(place),
    _options(options),
    _watch(watch),
    _cpu(options.cpu, options.fpga)
{
    _clock = {now_ns, options.started_ns, options.rate_ppm};
    _cpu.startClock(_clock);
    _bootedAt_ns = now_ns;
}

std::uint8_t EmulatedUnit::flags() const
{
    unsigned flags = 0;
    if (_standing.id != kNoId) flags |= 1U;
    if (_standing.isOpen) flags |= 2U;
    if (_standing.hasNext) flags |= 4U;
    // The grandmaster follows no clock, so it is synchronised from SetTime on; its pulse begins
    // later.
    if (_following.isLocked) flags |= 8U;
    if (_following.isLocked || (_standing.isGrandmaster && _standing.timeSetAt_ns >= 0))
        flags |= 16U;
    if (_standing.isGrandmaster) flags |= 32U;
    return static_cast<std::uint8_t>(flags);
}

std::vector<std::uint8_t> EmulatedUnit::info(Time_ns now_ns) const
{
    std::vector<std::uint8_t> bytes;
    base::ByteWriter writer(bytes);
    for (const int byte : {_standing.id,
                           int(flags()),
                           _standing.id == kNoId ? kPortUnknown : kUpstreamPort,
                           0,
                           int(_options.cpu.major),
                           int(_options.cpu.minor),
                           int(_options.cpu.patch),
                           0})
        writer.u8(static_cast<std::uint8_t>(byte));
    writer.u64(static_cast<std::uint64_t>(_clock.at(now_ns)));
    writer.u32(0); // offset from the grandmaster, as known to the unit
    return bytes;
}

void EmulatedUnit::answerStatus(const Request& request,
                                int status,
                                const std::vector<std::uint8_t>& more,
                                Time_ns now_ns)
{
    UnitAnswer answer{now_ns, _standing.id, request.peer, {}};
    base::ByteWriter writer(answer.bytes);
    writer.u8(static_cast<std::uint8_t>(_options.protocolVersion));
    writer.u8(request.kind);
    writer.u16(request.message);
    writer.u8(static_cast<std::uint8_t>(status));
    writer.bytes(more.data(), more.size());
    _answers.push_back(std::move(answer));
}

// Answers the last sender, whoever sent the frame.
void EmulatedUnit::answerFrame(std::uint8_t kind, std::uint16_t message, Time_ns now_ns)
{
    if (_standing.id == kNoId || !_host.isKnown) return;
    UnitAnswer answer{now_ns, _standing.id, _host.peer, {}};
    base::ByteWriter writer(answer.bytes);
    writer.u8(static_cast<std::uint8_t>(_options.protocolVersion));
    writer.u8(kind);
    writer.u16(message);
    writer.u8(_inbox.last.acknowledged);
    writer.u8(static_cast<std::uint8_t>(_inbox.last.result));
    writer.u8(flags());
    writer.u8(static_cast<std::uint8_t>(_standing.id));
    writer.u64(static_cast<std::uint64_t>(_clock.at(now_ns)));
    writer.bytes(_inbox.last.data.data(), _inbox.last.data.size());
    _answers.push_back(std::move(answer));
}

void EmulatedUnit::receive(
    const std::uint8_t* bytes, std::size_t size, bool toGroup, std::uint64_t peer, Time_ns now_ns)
{
    advance(now_ns);
    if (!isOn(now_ns) || size < kHeaderBytes || size > kUnitDatagramBytes) return;
    base::ByteReader header(bytes, kHeaderBytes);
    const int version = header.u8();
    Request request{header.u8(),
                    header.u16(),
                    toGroup,
                    peer,
                    base::ByteReader(bytes + kHeaderBytes, size - kHeaderBytes)};
    if (version != _options.protocolVersion)
    {
        answerStatus(request, OTHER_VERSION, {}, now_ns);
        return;
    }
    handle(request, now_ns);
}

void EmulatedUnit::handle(Request& request, Time_ns now_ns)
{
    const bool toGroup = request.toGroup;
    switch (request.kind)
    {
    case FRAME:
        takeFrame(request, now_ns);
        break;
    case READ_UNIT_INFO:
        answerStatus(request, DONE, info(now_ns), now_ns);
        break;
    case RESET_ID:
        answerStatus(request, DONE, {}, now_ns);
        _standing.losesIdAt_ns = std::min(_standing.losesIdAt_ns, now_ns + kLosesId_ns);
        break;
    case DISCOVER:
        if (_standing.id == kNoId) answerStatus(request, DONE, {}, now_ns);
        break;
    case ASSIGN_ID:
        if (!toGroup && _standing.id == kNoId) assignId(request, now_ns);
        break;
    case UNBLOCK_DOWNSTREAM:
        if (!toGroup) unblock(request, now_ns);
        break;
    case SET_TIME:
        if (!toGroup) setTime(request, now_ns);
        break;
    case HEARTBEAT:
        if (toGroup || _standing.id == kNoId) break;
        hear(request.peer, now_ns);
        answerFrame(HEARTBEAT, request.message, now_ns);
        break;
    default: // silence
        break;
    }
}

void EmulatedUnit::assignId(Request& request, Time_ns now_ns)
{
    const int id = request.body.u8();
    const int role = request.body.u8();
    const bool good = request.body.ok() && id != kNoId && role <= 1;
    if (good)
    {
        _standing.id = id;
        _standing.isGrandmaster = role == 1;
        _standing.assignedAt_ns = now_ns;
        _standing.losesIdAt_ns = kNever_ns; // cancels an earlier ResetId
    }
    answerStatus(request, good ? DONE : BAD_BODY, {}, now_ns);
}

void EmulatedUnit::unblock(const Request& request, Time_ns now_ns)
{
    if (_standing.id == kNoId) return answerStatus(request, HAS_NO_ID, {}, now_ns);
    _standing.isOpen = true;
    _standing.hasNext = _options.hasNext;
    answerStatus(request, DONE, {static_cast<std::uint8_t>(_standing.hasNext ? 1 : 0)}, now_ns);
}

void EmulatedUnit::setTime(Request& request, Time_ns now_ns)
{
    const std::uint64_t time_ns = request.body.u64();
    int status = DONE;
    if (_standing.id == kNoId)
        status = HAS_NO_ID;
    else if (!_standing.isGrandmaster)
        status = NOT_GRANDMASTER;
    else if (!request.body.ok() || time_ns / 1'000'000'000 > kMostSeconds)
        status = BAD_BODY;
    if (status == DONE)
    {
        _clock.set(now_ns, static_cast<Time_ns>(time_ns));
        _cpu.followClock(_clock, now_ns);
        _standing.timeSetAt_ns = now_ns;
    }
    answerStatus(request, status, {}, now_ns);
}

void EmulatedUnit::takeFrame(Request& request, Time_ns now_ns)
{
    if (request.toGroup || _standing.id == kNoId || request.body.left() < 2) return;
    hear(request.peer, now_ns);
    Frame frame;
    frame.message = request.message;
    frame.number = request.body.u8();
    frame.command = request.body.u8();
    const int received = frame.number * 256 + frame.command;
    if (received == _inbox.lastReceived)
    {
        // A waiting or out-of-order frame gets no answer.
        ++_cpu.telemetry.repeats;
        const bool isReset = frame.command == kReset;
        if (_inbox.last.acknowledged == (isReset ? kNothingDone : frame.number))
            answerFrame(FRAME, frame.message, now_ns);
        return;
    }
    if (_inbox.queue.size() >= kUnitQueue)
    {
        ++_cpu.telemetry.queueFull;
        return;
    }
    _inbox.lastReceived = received;
    const std::size_t size = request.body.left();
    const std::uint8_t* payload = request.body.bytes(size);
    frame.payload.assign(payload, payload + size);
    _inbox.busyUntil_ns = std::max(_inbox.busyUntil_ns, now_ns) + _options.perFrame_ns +
                          Time_ns(size / 2) * _options.perWord_ns;
    frame.done_ns = _inbox.busyUntil_ns;
    _inbox.queue.push_back(std::move(frame));
    advance(now_ns);
}

// The CPU counts its own milliseconds, so a frame late in a millisecond has less time.
Time_ns EmulatedUnit::failsafeAt_ns() const
{
    if (_host.heardAt_ns < 0 || _cpu.config().failsafe_ns == 0) return kNever_ns;
    const Time_ns since_ns = _host.heardAt_ns / kMillisecond_ns * kMillisecond_ns;
    return std::max(since_ns + _cpu.config().failsafe_ns, _failsafe.from_ns);
}

Time_ns EmulatedUnit::lockFailsafeAt_ns() const
{
    if (_following.lostAt_ns == kNever_ns || _cpu.config().lockFailsafe_ns == 0) return kNever_ns;
    return std::max(_following.lostAt_ns + _cpu.config().lockFailsafe_ns, _failsafe.from_ns);
}

Time_ns EmulatedUnit::nextEvent_ns() const
{
    Time_ns next_ns = std::min(_standing.losesIdAt_ns, _cpu.fpgaWhen(fpga().due_ns()));
    if (!_inbox.queue.empty()) next_ns = std::min(next_ns, _inbox.queue.front().done_ns);
    if (!_failsafe.isHostSilent) next_ns = std::min(next_ns, failsafeAt_ns());
    if (!_failsafe.isUnlockedLong) next_ns = std::min(next_ns, lockFailsafeAt_ns());
    return next_ns;
}

void EmulatedUnit::hear(std::uint64_t peer, Time_ns now_ns)
{
    _host.heardAt_ns = now_ns;
    _host.peer = peer;
    _host.isKnown = true;
    _failsafe.isHostSilent = false;
}

void EmulatedUnit::forgetTrips(Time_ns now_ns)
{
    _failsafe.isHostSilent = _failsafe.isUnlockedLong = false;
    _failsafe.from_ns = now_ns;
}

// Each cause trips it once; it stays tripped until ReleaseFailsafe or Clear, even if the cause
// ends.
void EmulatedUnit::trip(Time_ns now_ns)
{
    if (!_failsafe.isHostSilent && failsafeAt_ns() <= now_ns)
    {
        _failsafe.isHostSilent = true;
        tripFailsafe(now_ns);
    }
    if (!_failsafe.isUnlockedLong && lockFailsafeAt_ns() <= now_ns)
    {
        _failsafe.isUnlockedLong = true;
        ++_cpu.telemetry.lockFailsafe;
        close(now_ns);
    }
}

void EmulatedUnit::advance(Time_ns now_ns)
{
    for (Time_ns next_ns = nextEvent_ns(); next_ns <= now_ns; next_ns = nextEvent_ns())
    {
        if (_standing.losesIdAt_ns <= next_ns) loseId(next_ns);
        tellSwitches(next_ns);
        if (!_inbox.queue.empty() && _inbox.queue.front().done_ns <= next_ns)
        {
            const Frame frame = std::move(_inbox.queue.front());
            _inbox.queue.pop_front();
            finish(frame);
        }
        trip(next_ns);
    }
}

void EmulatedUnit::finish(const Frame& frame)
{
    if (frame.command == kReset)
    {
        _inbox.next = 0;
        _inbox.last = LastReply();
    }
    else if (frame.number == _inbox.next)
    {
        ++_inbox.next;
        const std::uint64_t intrusions = fpga().intrusions().banks;
        std::vector<std::uint8_t> data;
        const Result result = run(frame, data);
        if (result != Result::DONE) data.clear();
        _inbox.last = {frame.number, result, std::move(data)};
        if (result != Result::DONE) ++_cpu.telemetry.errors;
        ++_cpu.telemetry.done; // including refused ones
        tellWatch(frame, intrusions);
    }
    else
        ++_cpu.telemetry.outOfTurn; // repeats the last answer, with its data
    answerFrame(FRAME, frame.message, frame.done_ns);
}

Result EmulatedUnit::run(const Frame& frame, std::vector<std::uint8_t>& data)
{
    if (frame.command >= 0x70 && frame.command <= 0x78) ++_counts.updateCommands;
    if (_failing.commands > 0)
    {
        --_failing.commands;
        return static_cast<Result>(_failing.result);
    }
    const Time_ns now_ns = frame.done_ns;
    const UnitMoment moment{now_ns,
                            _clock.at(now_ns),
                            _following.isLocked,
                            std::min(failsafeAt_ns(), lockFailsafeAt_ns()) <= now_ns};
    return _cpu.run(frame.command, frame.payload.data(), frame.payload.size(), moment, data);
}

void EmulatedUnit::tellWatch(const Frame& frame, std::uint64_t intrusionsBefore)
{
    if (_inbox.last.result != Result::DONE) return;
    const Time_ns now_ns = frame.done_ns;
    switch (frame.command)
    {
    case kClear:
        forgetTrips(now_ns);
        _isMasked = false;
        _watch.cleared(_place, now_ns, fpga().content());
        break;
    case 0x05: // SetCpuConfig
        if (failsafeAt_ns() > now_ns) _failsafe.isHostSilent = false;
        if (lockFailsafeAt_ns() > now_ns) _failsafe.isUnlockedLong = false;
        _failsafe.from_ns = now_ns;
        break;
    case 0x06: // ReleaseFailsafe
        _watch.closed(_place, now_ns, _isMasked);
        break;
    case 0x12: // ActivatePatternBank
        tellSwitches(now_ns);
        _watch.changed(_place, now_ns, fpga().content()); // new registers
        break;
    case 0x41: // SetOutputMask
        _isMasked = isAllOff(frame.payload);
        if (_isMasked) _watch.closed(_place, now_ns, true);
        _watch.changed(_place, now_ns, fpga().content());
        if (!_isMasked) _watch.closed(_place, now_ns, fpga().gated());
        break;
    case 0x40:
    case 0x42:
        _watch.changed(_place, now_ns, fpga().content());
        break;
    default:
        if (fpga().intrusions().banks != intrusionsBefore)
            _watch.changed(_place, now_ns, fpga().content());
        break;
    }
}

void EmulatedUnit::tellSwitches(Time_ns now_ns)
{
    BankTimeline::Switch made;
    if (_cpu.fpga().takeSwitch(_cpu.fpgaTime(now_ns), made))
        _watch.switched(_place, _cpu.fpgaWhen(made.at_ns), fpga().content(), made.replays);
}

void EmulatedUnit::takeAnswers(std::vector<UnitAnswer>& answers)
{
    std::move(_answers.begin(), _answers.end(), std::back_inserter(answers));
    _answers.clear();
}

void EmulatedUnit::loseId(Time_ns now_ns)
{
    _standing = {};
    _host.isKnown = false;
    _cpu.restoreConfig();
    unlock(now_ns);
    _following.lostAt_ns = kNever_ns;
    _failsafe.isUnlockedLong = false;
    _failsafe.from_ns = now_ns;
}

void EmulatedUnit::lock(const EmulatedClock& clock, Time_ns now_ns)
{
    if (!_following.isLocked && _following.lostAt_ns != kNever_ns) ++_cpu.telemetry.resync;
    _following.isLocked = true;
    _following.lostAt_ns = kNever_ns;
    _failsafe.isUnlockedLong = false;
    _clock = clock;
    _cpu.followClock(_clock, now_ns);
}

void EmulatedUnit::unlock(Time_ns now_ns)
{
    if (!_following.isLocked) return;
    _following.isLocked = false;
    _following.lostAt_ns = now_ns;
    _clock.setRate(now_ns, _options.rate_ppm);
    _cpu.followClock(_clock, now_ns);
}

// Resets all but identity and counters to power-up; answers in transit continue.
void EmulatedUnit::reboot(Time_ns now_ns)
{
    advance(now_ns);
    _cpu.restart();
    _clock = {now_ns, _options.started_ns, _options.rate_ppm};
    _cpu.startClock(_clock);
    _bootedAt_ns = now_ns + std::max(_options.boot_ns, kMillisecond_ns);
    _isMasked = false;
    _standing = {};
    _following = {};
    _host = {};
    _inbox = {};
    _failsafe.isHostSilent = _failsafe.isUnlockedLong = false;
    _failing = {};
    _watch.rebooted(_place, now_ns, fpga().content());
}

void EmulatedUnit::tripFailsafe(Time_ns now_ns)
{
    ++_cpu.telemetry.failsafe;
    close(now_ns);
}

void EmulatedUnit::close(Time_ns now_ns)
{
    ++_counts.trips;
    _cpu.closeGate(now_ns);
    _watch.closed(_place, now_ns, true);
}

void EmulatedUnit::failCommands(std::uint8_t result, int count)
{
    _failing.result = result;
    _failing.commands = count;
}

std::vector<std::complex<float>> EmulatedUnit::output(Time_ns now_ns)
{
    advance(now_ns);
    if (!isOn(now_ns)) return std::vector<std::complex<float>>(kUnitTransducers);
    return _cpu.fpga().output(_cpu.fpgaTime(now_ns));
}

} // namespace midair::device::emulation
