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

constexpr std::size_t kPackedBytes = 125; // two 4-bit phases each

// Reads "rounds less 1, FFFF for ever".
std::uint32_t takeRounds(base::ByteReader& payload)
{
    const std::uint16_t less1 = payload.u16();
    return less1 == 0xFFFF ? 0 : less1 + 1U;
}

struct ReadActivation
{
    int bank = 0;
    Activation mode = Activation::NOW;
    std::uint64_t value = 0;
    bool understood = false;
};

ReadActivation takeActivation(base::ByteReader& payload)
{
    ReadActivation read;
    read.bank = payload.u8();
    const std::uint8_t mode = payload.u8();
    read.mode = static_cast<Activation>(mode);
    read.value = payload.u64();
    read.understood = read.bank <= 1 && (mode == 0x00 || mode == 0x01 || mode == 0xFF);
    return read;
}

void unpack(const std::uint8_t* packed, UnitLevels& phases)
{
    for (int i = 0; i < kUnitTransducers; ++i)
        phases[i] = static_cast<std::uint8_t>(
            17U * ((unsigned(packed[i / 2]) >> (i % 2 == 0 ? 0U : 4U)) & 15U));
}

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

Result
UnitCpu::configPattern(base::ByteReader& payload, const UnitMoment&, std::vector<std::uint8_t>&)
{
    const int bank = payload.u8();
    const bool raw = payload.u8() == 1;
    BankRegisters registers;
    registers.divider = payload.u16();
    registers.slots = payload.u32();
    payload.u32(); // reserved
    registers.rounds = takeRounds(payload);
    if (bank > 1 || !raw || registers.divider < 1 || registers.slots < 1 ||
        registers.slots > kMostSlots || (registers.rounds != 0 && registers.slots < 2))
        return Result::BAD_PAYLOAD;
    _fpga.configurePatterns(bank, registers);
    return Result::DONE;
}

Result UnitCpu::activatePattern(base::ByteReader& payload,
                                const UnitMoment& moment,
                                std::vector<std::uint8_t>&)
{
    const ReadActivation read = takeActivation(payload);
    if (!read.understood) return Result::BAD_PAYLOAD;
    return _fpga.activatePatterns(read.bank,
                                  read.mode,
                                  read.value,
                                  fpgaTime(moment.cable_ns),
                                  moment.unit_ns,
                                  _config.margin_ns);
}

Result UnitCpu::writePhases(base::ByteReader& payload,
                            const UnitMoment& moment,
                            std::vector<std::uint8_t>&)
{
    const int bank = payload.u8();
    const int bits = payload.u8();
    const std::uint32_t count = payload.u8();
    const std::uint8_t intensity = payload.u8();
    const std::uint32_t first = payload.u16();
    const std::size_t each = bits == 8 ? kUnitTransducers : kPackedBytes;
    if (!payload.ok() || bank > 1 || (bits != 8 && bits != 4) || count < 1 ||
        first + count > kMostSlots || payload.left() != count * each)
        return Result::BAD_PAYLOAD;
    for (std::uint32_t i = 0; i < count; ++i)
    {
        const std::uint8_t* phases = payload.bytes(each);
        UnitPattern pattern;
        pattern.intensity.fill(intensity);
        if (bits == 8)
            std::copy_n(phases, kUnitTransducers, pattern.phase.begin());
        else
            unpack(phases, pattern.phase);
        _fpga.writeSlot(bank, first + i, pattern, fpgaTime(moment.cable_ns));
    }
    return Result::DONE;
}

Result
UnitCpu::writeRaw(base::ByteReader& payload, const UnitMoment& moment, std::vector<std::uint8_t>&)
{
    const int bank = payload.u8();
    const std::uint32_t count = payload.u8();
    const std::uint32_t first = payload.u16();
    if (!payload.ok() || bank > 1 || count < 1 || count > 2 || first + count > kMostSlots ||
        payload.left() != count * 2U * kUnitTransducers)
        return Result::BAD_PAYLOAD;
    for (std::uint32_t i = 0; i < count; ++i)
    {
        UnitPattern pattern;
        std::copy_n(payload.bytes(kUnitTransducers), kUnitTransducers, pattern.phase.begin());
        std::copy_n(payload.bytes(kUnitTransducers), kUnitTransducers, pattern.intensity.begin());
        _fpga.writeSlot(bank, first + i, pattern, fpgaTime(moment.cable_ns));
    }
    return Result::DONE;
}

Result UnitCpu::writeModulation(base::ByteReader& payload,
                                const UnitMoment& moment,
                                std::vector<std::uint8_t>&)
{
    const int bank = payload.u8();
    payload.u8(); // reserved
    const std::uint32_t first = payload.u32();
    const std::size_t count = payload.left();
    if (!payload.ok() || bank > 1 || first % 2 != 0 || first > kMostSamples ||
        first + count > kMostSamples)
        return Result::BAD_PAYLOAD;
    _fpga.writeSamples(bank, first, payload.bytes(count), count, fpgaTime(moment.cable_ns));
    return Result::DONE;
}

Result
UnitCpu::configModulation(base::ByteReader& payload, const UnitMoment&, std::vector<std::uint8_t>&)
{
    const int bank = payload.u8();
    payload.u8(); // reserved
    BankRegisters registers;
    registers.divider = payload.u16();
    registers.slots = payload.u32();
    registers.rounds = takeRounds(payload);
    if (bank > 1 || registers.divider < 1 || registers.slots < 2 || registers.slots > kMostSamples)
        return Result::BAD_PAYLOAD;
    _fpga.configureModulation(bank, registers);
    return Result::DONE;
}

Result UnitCpu::activateModulation(base::ByteReader& payload,
                                   const UnitMoment& moment,
                                   std::vector<std::uint8_t>&)
{
    const ReadActivation read = takeActivation(payload);
    if (!read.understood) return Result::BAD_PAYLOAD;
    return _fpga.activateModulation(read.bank,
                                    read.mode,
                                    read.value,
                                    fpgaTime(moment.cable_ns),
                                    moment.unit_ns,
                                    _config.margin_ns);
}

Result UnitCpu::setSilencer(base::ByteReader& payload,
                            const UnitMoment& moment,
                            std::vector<std::uint8_t>&)
{
    const std::uint8_t flags = payload.u8();
    payload.u8(); // reserved
    UnitSilencer::Settings settings;
    settings.byRate = (flags & 1U) != 0;
    settings.strict = (flags & 2U) != 0;
    settings.rateIntensity = payload.u16();
    settings.ratePhase = payload.u16();
    settings.stepsIntensity = payload.u16();
    settings.stepsPhase = payload.u16();
    // Only what is used has to be there.
    const bool isGood = settings.byRate ? settings.rateIntensity > 0 && settings.ratePhase > 0
                                        : settings.stepsIntensity > 0 && settings.stepsPhase > 0;
    if (!isGood) return Result::BAD_PAYLOAD;
    return _fpga.setSilencer(settings, fpgaTime(moment.cable_ns));
}

Result UnitCpu::setCorrection(base::ByteReader& payload,
                              const UnitMoment& moment,
                              std::vector<std::uint8_t>&)
{
    UnitLevels levels;
    std::copy_n(payload.bytes(kUnitTransducers), kUnitTransducers, levels.begin());
    _fpga.setCorrection(levels, fpgaTime(moment.cable_ns));
    return Result::DONE;
}

Result
UnitCpu::setMask(base::ByteReader& payload, const UnitMoment& moment, std::vector<std::uint8_t>&)
{
    const std::uint8_t* bytes = payload.bytes(32);
    std::array<bool, kUnitTransducers> on{};
    for (int i = 0; i < kUnitTransducers; ++i)
        on[i] = ((unsigned(bytes[i / 8]) >> unsigned(i % 8)) & 1U) != 0;
    _fpga.setMask(on, fpgaTime(moment.cable_ns));
    return Result::DONE;
}

Result UnitCpu::setWidths(base::ByteReader& payload, const UnitMoment&, std::vector<std::uint8_t>&)
{
    UnitFpga::WidthTable widths{};
    for (std::uint16_t& width : widths) // no value is refused; the memory has 9 bits
        width = payload.u16() & 511U;
    _fpga.setWidths(widths);
    return Result::DONE;
}

} // namespace midair::device::emulation
