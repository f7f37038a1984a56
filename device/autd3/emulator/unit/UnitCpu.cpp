#include "device/autd3/emulator/unit/UnitCpu.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

constexpr int kByFields = -1; // the handler looks at what is left
constexpr int kAny = -2;      // whatever follows is ignored
constexpr std::uint8_t kEmulator = 0x8C;
constexpr std::uint8_t kBootImage = 1;

} // namespace

const UnitCpu::Command* UnitCpu::find(std::uint8_t number)
{
    static const Command kCommands[] = {
        {0x01, kAny, &UnitCpu::synchronize},     {0x03, kAny, &UnitCpu::clear},
        {0x04, kAny, &UnitCpu::nothing},         {0x05, 64, &UnitCpu::setConfig},
        {0x06, kAny, &UnitCpu::releaseFailsafe}, {0x11, 14, &UnitCpu::configPattern},
        {0x12, 10, &UnitCpu::activatePattern},   {0x13, kByFields, &UnitCpu::writePhases},
        {0x15, kByFields, &UnitCpu::writeRaw},   {0x20, kByFields, &UnitCpu::writeModulation},
        {0x21, 10, &UnitCpu::configModulation},  {0x22, 10, &UnitCpu::activateModulation},
        {0x30, 10, &UnitCpu::setSilencer},       {0x40, kUnitTransducers, &UnitCpu::setCorrection},
        {0x41, 32, &UnitCpu::setMask},           {0x42, 512, &UnitCpu::setWidths},
        {0x60, 1, &UnitCpu::forceFan},           {0xE7, kAny, &UnitCpu::readState},
        {0xE8, kAny, &UnitCpu::readTelemetry},   {0xEB, kAny, &UnitCpu::readFirmware},
        {0xEC, kAny, &UnitCpu::readImage},
    };
    const auto* found = std::find_if(std::begin(kCommands),
                                     std::end(kCommands),
                                     [&](const Command& one) { return one.number == number; });
    return found == std::end(kCommands) ? nullptr : found;
}

Result UnitCpu::run(std::uint8_t command,
                    const std::uint8_t* payload,
                    std::size_t size,
                    const UnitMoment& moment,
                    std::vector<std::uint8_t>& data)
{
    const Command* known = find(command);
    if (known == nullptr) return Result::UNKNOWN_COMMAND;
    if (known->bytes >= 0 && size != static_cast<std::size_t>(known->bytes))
        return Result::BAD_PAYLOAD;
    base::ByteReader reader(payload, size);
    return (this->*known->handler)(reader, moment, data);
}

void UnitCpu::closeGate(Time_ns cable_ns)
{
    _fpga.setGate(true, fpgaTime(cable_ns));
}

void UnitCpu::restart()
{
    telemetry = UnitTelemetry();
    _config = Config();
    _fpga.restart();
    _synchronized = _fan = false;
}

Time_ns UnitCpu::fpgaTime(Time_ns cable_ns) const
{
    return std::max<Time_ns>(0, _fpgaClock.at(cable_ns));
}

Time_ns UnitCpu::fpgaWhen(Time_ns reading_ns) const
{
    return _fpgaClock.when(reading_ns);
}

void UnitCpu::followClock(const EmulatedClock& clock, Time_ns cable_ns)
{
    _unitClock = clock;
    if (_synchronized)
        _fpgaClock = clock;
    else
        _fpgaClock.setRate(cable_ns, clock.rate_ppm);
}

Result UnitCpu::nothing(base::ByteReader&, const UnitMoment&, std::vector<std::uint8_t>&)
{
    return Result::DONE;
}

Result UnitCpu::synchronize(base::ByteReader&, const UnitMoment& moment, std::vector<std::uint8_t>&)
{
    if (!moment.syncRuns) return Result::NO_SYNC;
    // The hardware takes it at the next full millisecond; nothing waits for that here.
    _synchronized = true;
    _fpgaClock = _unitClock;
    return Result::DONE;
}

Result UnitCpu::clear(base::ByteReader&, const UnitMoment& moment, std::vector<std::uint8_t>&)
{
    _config = Config();
    _fan = false;
    _fpga.clear(fpgaTime(moment.cable_ns));
    UnitTelemetry kept; // the FPGA counts the first
    kept.resync = telemetry.resync;
    kept.bootFaults = telemetry.bootFaults;
    telemetry = kept;
    return Result::DONE;
}

Result UnitCpu::setConfig(base::ByteReader& payload, const UnitMoment&, std::vector<std::uint8_t>&)
{
    constexpr std::uint32_t kMostPpb = INT32_MAX;
    constexpr std::uint16_t kMostShift = 16;
    Config config;
    config.margin_ns = payload.u32();
    bool good = payload.u32() > 0;    // polls of the FPGA
    good = payload.u32() > 0 && good; // of its flash
    payload.u32();                    // guard of the sync pulse
    good = payload.u16() > 0 && good; // delay of an update
    good = payload.u16() > 0 && good; // from one Sync to the next
    payload.bytes(6);                 // time limits, holdover
    good = payload.u16() > 0 && good; // samples until it is locked
    payload.bytes(16);                // thresholds, gains
    good = payload.u32() <= kMostPpb && good;
    config.failsafe_ns = payload.u16() * kMillisecond_ns;
    good = payload.u16() > 0 && good; // Syncs to each request of the delay
    good = payload.u16() <= kMostShift && good;
    payload.bytes(6); // pauses
    config.lockFailsafe_ns = payload.u16() * kMillisecond_ns;
    const std::uint16_t busWait = payload.u16();
    if (!good || busWait < 2 || busWait > 3) return Result::BAD_PAYLOAD;
    _config = config;
    return Result::DONE;
}

Result
UnitCpu::releaseFailsafe(base::ByteReader&, const UnitMoment& moment, std::vector<std::uint8_t>&)
{
    if (moment.causeLasts) return Result::CAUSE_LASTS;
    _fpga.setGate(false, fpgaTime(moment.cable_ns));
    return Result::DONE;
}

Result UnitCpu::forceFan(base::ByteReader& payload, const UnitMoment&, std::vector<std::uint8_t>&)
{
    const std::uint8_t on = payload.u8();
    if (on > 1) return Result::BAD_PAYLOAD;
    _fan = on == 1;
    return Result::DONE;
}

Result
UnitCpu::readState(base::ByteReader&, const UnitMoment& moment, std::vector<std::uint8_t>& data)
{
    const Time_ns now_ns = fpgaTime(moment.cable_ns);
    const BankTimeline& patterns = _fpga.patterns();
    const BankTimeline& modulation = _fpga.modulation();
    unsigned state = hot ? 0x01U : 0U;
    if (modulation.bank() == 1) state |= 0x02U;
    if (patterns.bank() == 1) state |= 0x04U;
    if (patterns.playing().slots == 1) state |= 0x08U;
    if (patterns.endedAt(now_ns)) state |= 0x10U;
    if (modulation.endedAt(now_ns)) state |= 0x20U;
    if (patterns.waits() || modulation.waits()) state |= 0x40U;
    if (_fpga.gated()) state |= 0x80U;
    data.push_back(static_cast<std::uint8_t>(state));
    return Result::DONE;
}

Result UnitCpu::readTelemetry(base::ByteReader&, const UnitMoment&, std::vector<std::uint8_t>& data)
{
    base::ByteWriter writer(data);
    for (const std::uint32_t count : {telemetry.queueFull,
                                      telemetry.repeats,
                                      telemetry.outOfTurn,
                                      telemetry.errors,
                                      telemetry.done, // before this one
                                      telemetry.failsafe,
                                      telemetry.resync,
                                      telemetry.lockFailsafe,
                                      telemetry.sendsFailed,
                                      telemetry.bootFaults})
        writer.u32(count);
    return Result::DONE;
}

// Which image runs; what the byte means isn't known here.
Result UnitCpu::readImage(base::ByteReader&, const UnitMoment&, std::vector<std::uint8_t>& data)
{
    data.push_back(0);
    return Result::DONE;
}

Result UnitCpu::readFirmware(base::ByteReader&, const UnitMoment&, std::vector<std::uint8_t>& data)
{
    for (const UnitVersion& version : {_cpuVersion, _fpgaVersion})
        data.insert(data.end(), {version.major, version.minor, version.patch});
    data.insert(data.end(), {kEmulator, kBootImage});
    return Result::DONE;
}

} // namespace midair::device::emulation
