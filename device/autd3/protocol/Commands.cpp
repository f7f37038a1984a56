#include "device/autd3/protocol/Commands.h"

#include <algorithm>

namespace midair::device::autd3
{

namespace
{

constexpr std::uint64_t kForEver = 0xFFFF;
constexpr std::uint64_t kOnce = 0;
constexpr std::uint64_t kSlowestGlide = 256; ///< rates that the fixed number of steps ignores
constexpr std::size_t kMaskBytes = 32;

} // namespace

bool UnitPattern::isEven() const
{
    return std::all_of(intensity.begin(),
                       intensity.end(),
                       [&](std::uint8_t level) { return level == intensity.front(); });
}

bool Command::writesPatterns() const
{
    return code() == kConfigureBankCode || code() == kWritePhasesCode || code() == kWriteRawCode;
}

Command& Command::add(std::uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; ++i)
        _bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
}

Command& Command::add(const std::uint8_t* bytes, std::size_t count)
{
    _bytes.insert(_bytes.end(), bytes, bytes + count);
    return *this;
}

// Margin and failsafe are ours, the rest are the firmware's defaults: each command sets all.
Command Command::configureCpu(const CpuConfig& config)
{
    Command command(kConfigureCpuCode);
    command.add(config.switchMargin_ns, 4)
        .add(1'000'000, 4)     // polls
        .add(2'000'000'000, 4) // polls
        .add(250'000, 4)       // guard of the synchronisation, ns
        .add(100, 2)           // delay of an update, ms
        .add(8, 2)             // clock: interval, ms
        .add(3, 2)             // clock: time stamp, ms
        .add(6, 2)             // clock: answer, ms
        .add(1000, 2)          // clock: holdover, ms
        .add(64, 2)            // clock: samples
        .add(10'000, 4)        // clock: step, ns
        .add(100, 4)           // clock: lock, ns
        .add(50, 4)            // clock: proportional
        .add(1, 4)             // clock: integral
        .add(500'000, 4)       // clock: most, ppb
        .add(config.failsafe_ms, 2)
        .add(32, 2) // requests
        .add(5, 2)  // filter
        .add(48, 2) // pause
        .add(64, 2) // hold
        .add(8, 2)  // retry, ms
        .add(0, 2)  // without lock until the failsafe, ms: never
        .add(3, 2); // bus wait
    return command;
}

Command Command::configureBank(int bank, const BankConfig& config)
{
    return Command(kConfigureBankCode)
        .add(static_cast<std::uint64_t>(bank), 1)
        .add(1, 1) // raw
        .add(static_cast<std::uint64_t>(config.divider), 2)
        .add(static_cast<std::uint64_t>(config.slots), 4)
        .add(0, 4)
        .add(config.forEver ? kForEver : kOnce, 2);
}

Command Command::activateBank(int bank, SwitchMode mode, std::uint64_t time_ns)
{
    return Command(kActivateCode)
        .add(static_cast<std::uint64_t>(bank), 1)
        .add(static_cast<std::uint64_t>(mode), 1)
        .add(time_ns, 8);
}

Command Command::writePhases(int bank,
                             int first,
                             std::uint8_t intensity,
                             const std::vector<const UnitPattern*>& patterns)
{
    Command command(kWritePhasesCode);
    command.add(static_cast<std::uint64_t>(bank), 1)
        .add(8, 1)
        .add(patterns.size(), 1)
        .add(intensity, 1)
        .add(static_cast<std::uint64_t>(first), 2);
    for (const UnitPattern* pattern : patterns)
        command.add(pattern->phase.data(), pattern->phase.size());
    return command;
}

Command Command::writeRaw(int bank, int first, const std::vector<const UnitPattern*>& patterns)
{
    Command command(kWriteRawCode);
    command.add(static_cast<std::uint64_t>(bank), 1)
        .add(patterns.size(), 1)
        .add(static_cast<std::uint64_t>(first), 2);
    for (const UnitPattern* pattern : patterns)
        command.add(pattern->phase.data(), pattern->phase.size())
            .add(pattern->intensity.data(), pattern->intensity.size());
    return command;
}

Command Command::setSilencer(const Silencer& silencer)
{
    return Command(kSilencerCode)
        .add(0, 2)
        .add(kSlowestGlide, 2)
        .add(kSlowestGlide, 2)
        .add(static_cast<std::uint64_t>(silencer.intensitySteps), 2)
        .add(static_cast<std::uint64_t>(silencer.phaseSteps), 2);
}

Command Command::setOutputMask(const std::vector<int>& silent)
{
    std::array<std::uint8_t, kMaskBytes> mask{};
    for (std::size_t k = 0; k < kTransducersPerUnit; ++k)
        mask[k / 8] = static_cast<std::uint8_t>(mask[k / 8] | (1U << (k % 8)));
    for (const int index : silent)
    {
        const auto k = static_cast<std::size_t>(index);
        mask[k / 8] = static_cast<std::uint8_t>(mask[k / 8] & ~(1U << (k % 8)));
    }
    return Command(kMaskCode).add(mask.data(), mask.size());
}

Command Command::silenceAll()
{
    const std::array<std::uint8_t, kMaskBytes> mask{};
    return Command(kMaskCode).add(mask.data(), mask.size());
}

Command Command::setPulseWidths(const std::array<std::uint16_t, 256>& widths)
{
    Command command(kPulseWidthsCode);
    for (const std::uint16_t width : widths)
        command.add(width, 2);
    return command;
}

std::array<std::uint16_t, 256> dutyWidths()
{
    std::array<std::uint16_t, 256> widths{};
    for (unsigned duty = 0; duty < widths.size(); ++duty)
        widths[duty] = static_cast<std::uint16_t>((512 * duty + 255) / 510);
    return widths;
}

void toUnit(const DriveSignal& signal, int first, UnitPattern& pattern)
{
    for (std::size_t k = 0; k < pattern.phase.size(); ++k)
    {
        const std::size_t i = static_cast<std::size_t>(first) + k;
        pattern.intensity[k] = signal.duty[i];
        const std::uint8_t advance = signal.duty[i] == 0 ? std::uint8_t{0} : signal.phase[i];
        pattern.phase[k] = static_cast<std::uint8_t>(256U - advance);
    }
}

} // namespace midair::device::autd3
