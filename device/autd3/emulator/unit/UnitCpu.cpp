#include "device/autd3/emulator/unit/UnitCpu.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

constexpr int kByFields = -1; // the handler checks the remaining bytes
constexpr int kAny = -2;      // additional bytes are ignored
constexpr std::uint8_t kEmulator = 0x8C;
constexpr std::uint8_t kBootImage = 1;

constexpr std::size_t kPackedBytes = 125; // two 4-bit phases each

// Reads "rounds less 1, FFFF for ever".
std::uint32_t takeRounds(base::ByteReader& payload)
{
    const std::uint16_t less1 = payload.u16();
    return less1 == 0xFFFF ? 0 : less1 + 1U;
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
    Call call{base::ByteReader(payload, size), moment, data};
    return (this->*known->handler)(call);
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

Result UnitCpu::nothing(Call&)
{
    return Result::DONE;
}

Result UnitCpu::synchronize(Call& call)
{
    if (!call.moment.syncRuns) return Result::NO_SYNC;
    // The hardware applies it at the next full millisecond; nothing here depends on that.
    _synchronized = true;
    _fpgaClock = _unitClock;
    return Result::DONE;
}

Result UnitCpu::clear(Call& call)
{
    _config = Config();
    _fan = false;
    _fpga.clear(fpgaTime(call.moment.cable_ns));
    UnitTelemetry kept; // the FPGA has the first counter
    kept.resync = telemetry.resync;
    kept.bootFaults = telemetry.bootFaults;
    telemetry = kept;
    return Result::DONE;
}

Result UnitCpu::setConfig(Call& call)
{
    constexpr std::uint32_t kMostPpb = INT32_MAX;
    constexpr std::uint16_t kMostShift = 16;
    Config config;
    config.margin_ns = call.payload.u32();
    bool good = call.payload.u32() > 0;    // polls of the FPGA
    good = call.payload.u32() > 0 && good; // of its flash
    call.payload.u32();                    // guard of the sync pulse
    good = call.payload.u16() > 0 && good; // delay of an update
    good = call.payload.u16() > 0 && good; // from one Sync to the next
    call.payload.bytes(6);                 // time limits, holdover
    good = call.payload.u16() > 0 && good; // samples until it is locked
    call.payload.bytes(16);                // thresholds, gains
    good = call.payload.u32() <= kMostPpb && good;
    config.failsafe_ns = call.payload.u16() * kMillisecond_ns;
    good = call.payload.u16() > 0 && good; // Syncs to each request of the delay
    good = call.payload.u16() <= kMostShift && good;
    call.payload.bytes(6); // pauses
    config.lockFailsafe_ns = call.payload.u16() * kMillisecond_ns;
    const std::uint16_t busWait = call.payload.u16();
    if (!good || busWait < 2 || busWait > 3) return Result::BAD_PAYLOAD;
    _config = config;
    return Result::DONE;
}

Result UnitCpu::releaseFailsafe(Call& call)
{
    if (call.moment.causeLasts) return Result::CAUSE_LASTS;
    _fpga.setGate(false, fpgaTime(call.moment.cable_ns));
    return Result::DONE;
}

Result UnitCpu::forceFan(Call& call)
{
    const std::uint8_t on = call.payload.u8();
    if (on > 1) return Result::BAD_PAYLOAD;
    _fan = on == 1;
    return Result::DONE;
}

Result UnitCpu::readState(Call& call)
{
    const Time_ns now_ns = fpgaTime(call.moment.cable_ns);
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
    call.data.push_back(static_cast<std::uint8_t>(state));
    return Result::DONE;
}

Result UnitCpu::readTelemetry(Call& call)
{
    base::ByteWriter writer(call.data);
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

// Which image runs; the meaning of the byte is unknown here.
Result UnitCpu::readImage(Call& call)
{
    call.data.push_back(0);
    return Result::DONE;
}

Result UnitCpu::readFirmware(Call& call)
{
    for (const UnitVersion& version : {_cpuVersion, _fpgaVersion})
        call.data.insert(call.data.end(), {version.major, version.minor, version.patch});
    call.data.insert(call.data.end(), {kEmulator, kBootImage});
    return Result::DONE;
}

Result UnitCpu::configPattern(Call& call)
{
    const int bank = call.payload.u8();
    const bool raw = call.payload.u8() == 1;
    BankRegisters registers;
    registers.divider = call.payload.u16();
    registers.slots = call.payload.u32();
    call.payload.u32(); // reserved
    registers.rounds = takeRounds(call.payload);
    if (bank > 1 || !raw || registers.divider < 1 || registers.slots < 1 ||
        registers.slots > kMostSlots || (registers.rounds != 0 && registers.slots < 2))
        return Result::BAD_PAYLOAD;
    _fpga.configurePatterns(bank, registers);
    return Result::DONE;
}

// False: invalid payload.
bool UnitCpu::readActivating(Call& call, Activating& command) const
{
    command.bank = call.payload.u8();
    const std::uint8_t mode = call.payload.u8();
    command.mode = static_cast<Activation>(mode);
    command.value = call.payload.u64();
    command.fpga_ns = fpgaTime(call.moment.cable_ns);
    command.cpu_ns = call.moment.unit_ns;
    command.margin_ns = _config.margin_ns;
    return command.bank <= 1 && (mode == 0x00 || mode == 0x01 || mode == 0xFF);
}

Result UnitCpu::activatePattern(Call& call)
{
    Activating command;
    if (!readActivating(call, command)) return Result::BAD_PAYLOAD;
    return _fpga.activatePatterns(command);
}

Result UnitCpu::writePhases(Call& call)
{
    const int bank = call.payload.u8();
    const int bits = call.payload.u8();
    const std::uint32_t count = call.payload.u8();
    const std::uint8_t intensity = call.payload.u8();
    const std::uint32_t first = call.payload.u16();
    const std::size_t each = bits == 8 ? kUnitTransducers : kPackedBytes;
    if (!call.payload.ok() || bank > 1 || (bits != 8 && bits != 4) || count < 1 ||
        first + count > kMostSlots || call.payload.left() != count * each)
        return Result::BAD_PAYLOAD;
    for (std::uint32_t i = 0; i < count; ++i)
    {
        const std::uint8_t* phases = call.payload.bytes(each);
        UnitPattern pattern;
        pattern.intensity.fill(intensity);
        if (bits == 8)
            std::copy_n(phases, kUnitTransducers, pattern.phase.begin());
        else
            unpack(phases, pattern.phase);
        _fpga.writeSlot(bank, first + i, pattern, fpgaTime(call.moment.cable_ns));
    }
    return Result::DONE;
}

Result UnitCpu::writeRaw(Call& call)
{
    const int bank = call.payload.u8();
    const std::uint32_t count = call.payload.u8();
    const std::uint32_t first = call.payload.u16();
    if (!call.payload.ok() || bank > 1 || count < 1 || count > 2 || first + count > kMostSlots ||
        call.payload.left() != count * 2U * kUnitTransducers)
        return Result::BAD_PAYLOAD;
    for (std::uint32_t i = 0; i < count; ++i)
    {
        UnitPattern pattern;
        std::copy_n(call.payload.bytes(kUnitTransducers), kUnitTransducers, pattern.phase.begin());
        std::copy_n(
            call.payload.bytes(kUnitTransducers), kUnitTransducers, pattern.intensity.begin());
        _fpga.writeSlot(bank, first + i, pattern, fpgaTime(call.moment.cable_ns));
    }
    return Result::DONE;
}

Result UnitCpu::writeModulation(Call& call)
{
    const int bank = call.payload.u8();
    call.payload.u8(); // reserved
    const std::uint32_t first = call.payload.u32();
    const std::size_t count = call.payload.left();
    if (!call.payload.ok() || bank > 1 || first % 2 != 0 || first > kMostSamples ||
        first + count > kMostSamples)
        return Result::BAD_PAYLOAD;
    _fpga.writeSamples(
        bank, first, call.payload.bytes(count), count, fpgaTime(call.moment.cable_ns));
    return Result::DONE;
}

Result UnitCpu::configModulation(Call& call)
{
    const int bank = call.payload.u8();
    call.payload.u8(); // reserved
    BankRegisters registers;
    registers.divider = call.payload.u16();
    registers.slots = call.payload.u32();
    registers.rounds = takeRounds(call.payload);
    if (bank > 1 || registers.divider < 1 || registers.slots < 2 || registers.slots > kMostSamples)
        return Result::BAD_PAYLOAD;
    _fpga.configureModulation(bank, registers);
    return Result::DONE;
}

Result UnitCpu::activateModulation(Call& call)
{
    Activating command;
    if (!readActivating(call, command)) return Result::BAD_PAYLOAD;
    return _fpga.activateModulation(command);
}

Result UnitCpu::setSilencer(Call& call)
{
    const std::uint8_t flags = call.payload.u8();
    call.payload.u8(); // reserved
    UnitSilencer::Settings settings;
    settings.byRate = (flags & 1U) != 0;
    settings.strict = (flags & 2U) != 0;
    settings.rateIntensity = call.payload.u16();
    settings.ratePhase = call.payload.u16();
    settings.stepsIntensity = call.payload.u16();
    settings.stepsPhase = call.payload.u16();
    // Only values in use are required.
    const bool isGood = settings.byRate ? settings.rateIntensity > 0 && settings.ratePhase > 0
                                        : settings.stepsIntensity > 0 && settings.stepsPhase > 0;
    if (!isGood) return Result::BAD_PAYLOAD;
    return _fpga.setSilencer(settings, fpgaTime(call.moment.cable_ns));
}

Result UnitCpu::setCorrection(Call& call)
{
    UnitLevels levels;
    std::copy_n(call.payload.bytes(kUnitTransducers), kUnitTransducers, levels.begin());
    _fpga.setCorrection(levels, fpgaTime(call.moment.cable_ns));
    return Result::DONE;
}

Result UnitCpu::setMask(Call& call)
{
    const std::uint8_t* bytes = call.payload.bytes(32);
    std::array<bool, kUnitTransducers> on{};
    for (int i = 0; i < kUnitTransducers; ++i)
        on[i] = ((unsigned(bytes[i / 8]) >> unsigned(i % 8)) & 1U) != 0;
    _fpga.setMask(on, fpgaTime(call.moment.cable_ns));
    return Result::DONE;
}

Result UnitCpu::setWidths(Call& call)
{
    UnitFpga::WidthTable widths{};
    for (std::uint16_t& width : widths) // any value is accepted; the memory has 9 bits
        width = call.payload.u16() & 511U;
    _fpga.setWidths(widths);
    return Result::DONE;
}

} // namespace midair::device::emulation
