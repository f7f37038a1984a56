// The commands that write what a unit plays, and how.

#include "device/autd3/emulator/unit/UnitCpu.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

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
