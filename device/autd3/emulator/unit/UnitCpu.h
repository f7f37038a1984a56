#pragma once

#include "device/autd3/emulator/unit/UnitFpga.h"
#include "haptics/base/Bytes.h"

#include <array>
#include <cstdint>
#include <vector>

namespace midair::device::emulation
{

/// A version, as reported by units.
struct UnitVersion
{
    std::uint8_t major = 0;
    std::uint8_t minor = 10;
    std::uint8_t patch = 0;
};

/// Counters of a unit, in the order of its answer.
struct UnitTelemetry
{
    std::uint32_t queueFull = 0;
    std::uint32_t repeats = 0;
    std::uint32_t outOfTurn = 0;
    std::uint32_t errors = 0;
    std::uint32_t done = 0;
    std::uint32_t failsafe = 0;
    std::uint32_t resync = 0;
    std::uint32_t lockFailsafe = 0;
    std::uint32_t sendsFailed = 0;
    std::uint32_t bootFaults = 0;
};

/// State when a command is done: three clocks, and whether the cause of a failsafe lasts.
struct UnitMoment
{
    Time_ns cable_ns = 0;
    Time_ns unit_ns = 0;
    bool syncRuns = false;
    bool causeLasts = false;
};

/// Commands of a unit, their lengths and results, as in firmware 0.10 (sources in PROTOCOL.md). Not
/// emulated, and refused as bad payload: foci, switches by GPIO, alternating banks; as unknown:
/// firmware update, GPIO, reboot.
class UnitCpu
{
public:
    /// Part of SetCpuConfig that affects the emulation.
    struct Config
    {
        Time_ns margin_ns = 10 * kMillisecond_ns;
        Time_ns failsafe_ns = 500 * kMillisecond_ns; ///< 0: never
        Time_ns lockFailsafe_ns = 0;                 ///< 0: never
    };

    UnitCpu(const UnitVersion& cpu, const UnitVersion& fpga) : _cpuVersion(cpu), _fpgaVersion(fpga)
    {
    }

    /// Does a command with the bytes \a payload after its number; appends the data of a read to \a
    /// data.
    Result run(std::uint8_t command,
               const std::uint8_t* payload,
               std::size_t size,
               const UnitMoment& moment,
               std::vector<std::uint8_t>& data);

    /// Closes the gate until ReleaseFailsafe or Clear.
    void closeGate(Time_ns cable_ns);

    Time_ns fpgaTime(Time_ns cable_ns) const;
    /// cable time of a reading
    Time_ns fpgaWhen(Time_ns reading_ns) const { return _fpgaClock.when(reading_ns); }
    /// The unit's clock was set, or changed its rate, at \a cable_ns.
    void followClock(const EmulatedClock& clock, Time_ns cable_ns);
    /// At power-up: the FPGA's clock equals the unit's, but runs free from then on.
    void startClock(const EmulatedClock& clock) { _unitClock = _fpgaClock = clock; }
    void restart(); ///< power cycle; keeps its identity
    void restoreConfig() { _config = Config(); }

    UnitFpga& fpga() { return _fpga; }
    const UnitFpga& fpga() const { return _fpga; }
    const Config& config() const { return _config; }
    bool fan() const { return _fan; }
    UnitTelemetry telemetry;
    bool hot = false;

private:
    /// A command being done: payload, time, and data of a read.
    struct Call
    {
        base::ByteReader payload;
        const UnitMoment& moment;
        std::vector<std::uint8_t>& data;
    };
    using Handler = Result (UnitCpu::*)(Call&);
    /// A command: number, payload length (-1: by its fields; -2: any), and handler.
    struct Command
    {
        std::uint8_t number;
        int bytes;
        Handler handler;
    };
    static const Command* find(std::uint8_t number);
    bool readActivating(Call& call, Activating& command) const;

    Result nothing(Call& call);
    Result synchronize(Call& call);
    Result clear(Call& call);
    Result setConfig(Call& call);
    Result releaseFailsafe(Call& call);
    Result configPattern(Call& call);
    Result activatePattern(Call& call);
    Result writePhases(Call& call);
    Result writeRaw(Call& call);
    Result writeModulation(Call& call);
    Result configModulation(Call& call);
    Result activateModulation(Call& call);
    Result setSilencer(Call& call);
    Result setCorrection(Call& call);
    Result setMask(Call& call);
    Result setWidths(Call& call);
    Result forceFan(Call& call);
    Result readState(Call& call);
    Result readTelemetry(Call& call);
    Result readImage(Call& call);
    Result readFirmware(Call& call);

    const UnitVersion _cpuVersion;
    const UnitVersion _fpgaVersion;
    Config _config;
    UnitFpga _fpga;
    EmulatedClock _unitClock;
    /// Free-running until Synchronize.
    EmulatedClock _fpgaClock;
    bool _synchronized = false;
    bool _fan = false;
};

} // namespace midair::device::emulation
