#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"
#include "device/drive/DriveSignal.h"

#include <algorithm>
#include <array>
#include <complex>
#include <cstdint>
#include <vector>

namespace midair::device::emulation
{

/// Results of commands, as a unit answers them.
enum class Result : std::uint8_t
{
    DONE = 0x00,
    UNKNOWN_COMMAND = 0x01,
    BAD_PAYLOAD = 0x02,
    SILENCER = 0x04,
    MODE = 0x05,
    TIME = 0x06,
    NO_SYNC = 0x08,
    CAUSE_LASTS = 0x15
};

/// Timing mode of an activation.
enum class Activation : std::uint8_t
{
    INDEX = 0x00,
    TIME = 0x01,
    NOW = 0xFF
};

/// The registers of a bank.
struct BankRegisters
{
    std::uint32_t divider = 0xFFFF; ///< slots change every divider periods
    std::uint32_t slots = 1;        ///< patterns, or samples of a modulation
    std::uint32_t rounds = 0;       ///< 0: for ever

    Time_ns slot_ns() const { return Time_ns(divider) * kPeriod_ns; }
};

/// A command to switch banks, and the times when it is done.
struct Activating
{
    int bank = 0;
    Activation mode = Activation::NOW;
    std::uint64_t value = 0;
    Time_ns fpga_ns = 0;
    Time_ns cpu_ns = 0;
    Time_ns margin_ns = 0; ///< minimum time to a switch
};

/// Tracks which of two banks plays, and which slot: of patterns, or of the modulation. Times are
/// readings of the FPGA's clock, except the margin, which the CPU checks by its own.
class BankTimeline
{
public:
    /// A completed switch.
    struct Switch
    {
        Time_ns at_ns = 0; ///< edge of the period from which the bank plays
        int bank = 0;
        bool replays = false; ///< the previously playing bank plays again
    };

    void clear(std::uint32_t slots); ///< bank 0 plays for ever, both with \a slots
    void configure(int bank, const BankRegisters& registers) { _written[bank] = registers; }

    /// Plans a switch, or makes it (NOW), and validates the registers of both banks. \a steps:
    /// minimum divider of playing banks.
    Result activate(const Activating& command, int steps);
    /// Returns true if the dividers of the playing and waiting banks reach \a steps.
    bool reaches(int steps) const;

    bool waits() const { return _waits; }
    Time_ns due_ns() const { return _waits ? _due_ns : kNever_ns; }
    /// Makes the waiting switch if it is due by \a fpga_ns, or reports one made at once; returns
    /// true once, with its data in \a made.
    bool takeSwitch(Time_ns fpga_ns, Switch& made);

    int bank() const { return _bank; }
    int waitingBank() const { return _requested; } ///< the playing one if none waits
    bool forEver() const { return _forEver; }
    const BankRegisters& playing() const { return _valid[_bank]; }
    const BankRegisters& valid(int bank) const { return _valid[bank]; }
    const BankRegisters& written(int bank) const { return _written[bank]; }
    std::uint32_t slotAt(Time_ns fpga_ns) const;
    bool endedAt(Time_ns fpga_ns) const; ///< its rounds are over, the last slot is held

private:
    void play(int bank, Time_ns at_ns, bool forEver);

    std::array<BankRegisters, 2> _written;
    std::array<BankRegisters, 2> _valid;
    int _bank = 0;
    int _requested = 0;
    bool _forEver = true;
    Time_ns _start_ns = 0; ///< of the rounds
    bool _waits = false;
    Time_ns _due_ns = 0;
    bool _switched = false; ///< _last wasn't taken yet
    Switch _last;
};

constexpr int kUnitTransducers = 249;
using UnitLevels = std::array<std::uint8_t, kUnitTransducers>;

/// Phases and intensities of a unit in its memory.
struct UnitPattern
{
    UnitLevels phase{};
    UnitLevels intensity{};

    bool operator==(const UnitPattern& other) const
    {
        return phase == other.phase && intensity == other.intensity;
    }
};

/// Moves phases (the short way round) and intensities gradually, period by period.
class UnitSilencer
{
public:
    /// Speed: number of periods, or 1/256 levels per period.
    struct Settings
    {
        bool byRate = false;
        bool strict = false;
        std::uint16_t rateIntensity = 256;
        std::uint16_t ratePhase = 256;
        std::uint16_t stepsIntensity = 10;
        std::uint16_t stepsPhase = 40;
    };

    void set(const Settings& settings) { _settings = settings; }
    const Settings& settings() const { return _settings; }

    void head(const UnitPattern& target); ///< begins to move there
    void jump(const UnitPattern& target); ///< is there at once
    void glide(Time_ns periods);          ///< advances by a number of periods

    float phase(int transducer) const { return _phase[transducer].value; }
    float intensity(int transducer) const { return _intensity[transducer].value; }

private:
    /// A moving value.
    struct Gliding
    {
        float value = 0;
        float target = 0; ///< for phases: the equivalent nearest to value
        float step = 0;
        int left = 0; ///< remaining periods, if it moves by steps

        void headFor(float next, int steps);
        void pass(Time_ns periods, bool byRate, float rate);
    };

    Settings _settings;
    std::array<Gliding, kUnitTransducers> _phase{};
    std::array<Gliding, kUnitTransducers> _intensity{};
};

constexpr std::uint32_t kMostSlots = 1024;
constexpr std::uint32_t kMostSamples = 65536;

/// Playing part of a unit: two pattern banks, two modulation banks, silencer and outputs. Times are
/// readings of its clock, which never decrease unless it is set.
class UnitFpga
{
public:
    using WidthTable = std::array<std::uint16_t, 256>; ///< of 512 parts of the period

    /// Writes into playing or soon playing memory.
    struct Intrusions
    {
        std::uint64_t banks = 0; ///< into a slot of the playing or waiting bank
        std::uint64_t slots = 0; ///< into the playing slot itself
    };

    UnitFpga() { clear(0); }

    void clear(Time_ns now_ns);            ///< all defaults, silence; slots beyond the first stay
    void restart() { *this = UnitFpga(); } ///< power cycle: loses everything

    void writeSlot(int bank, std::uint32_t slot, const UnitPattern& pattern, Time_ns now_ns);
    void writeSamples(int bank,
                      std::uint32_t first,
                      const std::uint8_t* samples,
                      std::size_t count,
                      Time_ns now_ns);
    /// Writes the registers of a bank; the next activation checks them.
    void configurePatterns(int bank, const BankRegisters& r) { _patterns.configure(bank, r); }
    void configureModulation(int bank, const BankRegisters& r) { _modulation.configure(bank, r); }
    Result activatePatterns(const Activating& command);
    Result activateModulation(const Activating& command);
    Result setSilencer(const UnitSilencer::Settings& settings, Time_ns now_ns);
    void setCorrection(const UnitLevels& levels, Time_ns now_ns);
    void setMask(const std::array<bool, kUnitTransducers>& on, Time_ns now_ns);
    void setWidths(const WidthTable& widths) { _widths = widths; }
    void setGate(bool closed, Time_ns now_ns); ///< closed: intensity 0, whatever is written

    /// Makes switches that are due by \a now_ns; returns true once for each, with its data in \a
    /// made.
    bool takeSwitch(Time_ns now_ns, BankTimeline::Switch& made);
    Time_ns due_ns() const { return std::min(_patterns.due_ns(), _modulation.due_ns()); }

    const BankTimeline& patterns() const { return _patterns; }
    const BankTimeline& modulation() const { return _modulation; }
    const Intrusions& intrusions() const { return _intrusions; }
    bool gated() const { return _gated; }

    /// Hash of the whole cycle of the playing bank in our levels, without gate, modulation and
    /// silencer: contentOf() of its pattern if all slots are equal.
    std::uint64_t content() const;
    /// The playing slot, in our levels, without gate, modulation and silencer.
    DriveSignal field(Time_ns now_ns) const
    {
        return inOurLevels(slotOf(_patterns.bank(), _patterns.slotAt(now_ns)));
    }
    /// Output of the transducers, including the silencer, relative to full drive.
    std::vector<std::complex<float>> output(Time_ns now_ns);

private:
    UnitPattern slotOf(int bank, std::uint32_t slot) const
    {
        return slot < _slots[bank].size() ? _slots[bank][slot] : UnitPattern();
    }
    DriveSignal inOurLevels(const UnitPattern& pattern) const;
    UnitPattern target(Time_ns now_ns) const;
    std::uint8_t sampleAt(Time_ns now_ns) const;
    void render(Time_ns now_ns); ///< advances the silencer until now with the previous output
    void lookAtModulation();

    std::array<std::vector<UnitPattern>, 2> _slots; ///< as many as were written
    std::array<std::vector<std::uint8_t>, 2> _samples;
    BankTimeline _patterns;
    BankTimeline _modulation;
    bool _steady = true; ///< all samples of the playing modulation are equal
    UnitSilencer _silencer;
    Time_ns _rendered_ns = 0; ///< edge of a period
    UnitLevels _correction{};
    std::array<bool, kUnitTransducers> _on{};
    WidthTable _widths{};
    bool _gated = false;
    Intrusions _intrusions;
};

/// Hash of a unit's field in our levels; transducers that are off are equal.
std::uint64_t contentOf(const std::uint8_t* phase, const std::uint8_t* duty);

/// Hash of a cycle of fields: that of the field if all are equal.
class CycleContent
{
public:
    void add(std::uint64_t field);
    std::uint64_t value() const { return _alike ? _first : _all; }

private:
    bool _empty = true;
    bool _alike = true;
    std::uint64_t _first = 0;
    std::uint64_t _all = 0;
};

/// Returns our duty level nearest to a width in 1/512 of the period.
std::uint8_t dutyOfWidth(std::uint16_t width);

} // namespace midair::device::emulation
