#include "device/autd3/emulator/unit/EmulatedUnit.h"

#include <algorithm>

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
constexpr std::uint64_t kMostSeconds = UINT32_MAX; // that a clock has
constexpr int kPortUnknown = 0xFF;
constexpr int kUpstreamPort = 0;
constexpr std::uint8_t kResetCommand = 0x00;

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
    // The grandmaster follows nobody, so it is in step from SetTime on; its pulse begins later.
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
    writer.u32(0); // offset from the grandmaster, as it knows it
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

// To who spoke to it last, whoever sent the frame.
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
        _standing.losesIdAt_ns = kNever_ns; // a ResetId before is forgotten
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
        // One that waits, or was out of turn, gets no answer.
        ++_cpu.telemetry.repeats;
        const bool isReset = frame.command == kResetCommand;
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

} // namespace midair::device::emulation
