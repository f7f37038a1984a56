#pragma once

#include "device/drive/DriveSignal.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace midair::device::autd3
{

constexpr int kTransducersPerUnit = 249;
constexpr int kBanks = 2;          ///< of patterns; one plays
constexpr int kMostSlots = 1024;   ///< patterns in a bank
constexpr int kMostRawSlots = 2;   ///< in one frame
constexpr int kMostPhaseSlots = 5; ///< in one frame, 8 bits a phase
constexpr int kSlotPeriod_ns = 25'000;
constexpr int kMostDivider = 65535;

/// Pattern of one unit, in its own levels: a phase is a delay of 1/256 periods, an intensity an
/// index into the table of pulse widths.
struct UnitPattern
{
    std::array<std::uint8_t, kTransducersPerUnit> phase{};
    std::array<std::uint8_t, kTransducersPerUnit> intensity{};

    /// Returns true if all intensities are equal, so that the shorter frame of phases suffices.
    bool isEven() const;
    bool operator==(const UnitPattern& other) const
    {
        return phase == other.phase && intensity == other.intensity;
    }
};

/// Settings of a unit's processor; the defaults are the firmware's.
struct CpuConfig
{
    std::uint32_t switchMargin_ns = 10'000'000; ///< minimum time to a timed switch
    std::uint16_t failsafe_ms = 500; ///< without a frame or heartbeat: intensity 0; 0: never
};

/// Transition times of patterns and pulses.
struct Silencer
{
    int phaseSteps = 40;     ///< periods, 1 .. 65535; 1: none
    int intensitySteps = 10; ///< periods, 1 .. 65535; 1: none

    bool operator==(const Silencer& other) const
    {
        return phaseSteps == other.phaseSteps && intensitySteps == other.intensitySteps;
    }
};

/// Settings of a pattern bank.
struct BankConfig
{
    int divider = 1;     ///< 1 .. kMostDivider; a slot lasts divider x 25 us
    int slots = 1;       ///< 1 .. kMostSlots
    bool forEver = true; ///< synchronised with the units' time; false: once, then the last slot is
                         ///< held

    bool operator==(const BankConfig& other) const
    {
        return divider == other.divider && slots == other.slots && forEver == other.forEver;
    }
    bool operator!=(const BankConfig& other) const { return !(*this == other); }
};

/// Timing of an activation.
enum class SwitchMode : std::uint8_t
{
    AT_TIME = 0x01, ///< of the units' clock; for banks played once
    AT_ONCE = 0xFF  ///< for banks played for ever
};

constexpr std::uint8_t kResetCode = 0x00;
constexpr std::uint8_t kConfigureCpuCode = 0x05;
constexpr std::uint8_t kReleaseCode = 0x06;
constexpr std::uint8_t kConfigureBankCode = 0x11;
constexpr std::uint8_t kActivateCode = 0x12;
constexpr std::uint8_t kWritePhasesCode = 0x13;
constexpr std::uint8_t kWriteRawCode = 0x15;
constexpr std::uint8_t kSilencerCode = 0x30;
constexpr std::uint8_t kMaskCode = 0x41;
constexpr std::uint8_t kPulseWidthsCode = 0x42;
constexpr std::uint8_t kReadFpgaStateCode = 0xE7;
constexpr std::uint8_t kReadFirmwareCode = 0xEB;

/// A command to a unit: the body of a frame after the sequence number. Only the functions below
/// make commands, so none can touch the firmware.
class Command
{
public:
    static Command reset() { return Command(kResetCode); }
    static Command synchronize() { return Command(0x01); }
    static Command clear() { return Command(0x03); }
    static Command nop() { return Command(0x04); }
    static Command configureCpu(const CpuConfig& config);
    static Command releaseFailsafe() { return Command(kReleaseCode); }

    // A bank is 0 or 1. Writes slots first .. first + patterns.size() - 1.
    static Command configureBank(int bank, const BankConfig& config);
    static Command activateBank(int bank, SwitchMode mode, std::uint64_t time_ns = 0);
    /// Writes 1 .. kMostPhaseSlots phase patterns, all with one intensity.
    static Command writePhases(int bank,
                               int first,
                               std::uint8_t intensity,
                               const std::vector<const UnitPattern*>& patterns);
    /// Writes phases and intensities, 1 .. kMostRawSlots of them.
    static Command writeRaw(int bank, int first, const std::vector<const UnitPattern*>& patterns);

    static Command setSilencer(const Silencer& silencer);
    /// \a silent: permanently silent transducers, 0 .. 248.
    static Command setOutputMask(const std::vector<int>& silent);
    static Command silenceAll(); ///< an output mask of all transducers
    static Command setPulseWidths(const std::array<std::uint16_t, 256>& widths); ///< 0 .. 511
    static Command readFpgaState() { return Command(kReadFpgaStateCode); }
    static Command readTelemetry() { return Command(0xE8); }
    static Command readFirmware() { return Command(kReadFirmwareCode); }

    std::uint8_t code() const { return _bytes.front(); }
    bool writesPatterns() const; ///< or configures their bank
    const std::vector<std::uint8_t>& bytes() const { return _bytes; }

private:
    explicit Command(std::uint8_t code) : _bytes{code} {}

    Command& add(std::uint64_t value, int bytes); ///< the lowest byte first
    Command& add(const std::uint8_t* bytes, std::size_t count);

    std::vector<std::uint8_t> _bytes;
};

/// Widths in 1/512 of the period for which intensity D plays our duty level D: a pulse of D/510.
std::array<std::uint16_t, 256> dutyWidths();

/// Sets \a pattern to the transducers \a first .. \a first + 248 of \a signal, in the unit's levels
/// with dutyWidths(). A unit's phase is a delay, ours an advance. Transducers that are off get
/// phase 0, so that equal outputs have equal patterns.
void toUnit(const DriveSignal& signal, int first, UnitPattern& pattern);

} // namespace midair::device::autd3
