#pragma once

#include "device/autd3/emulator/unit/BankTimeline.h"
#include "device/autd3/emulator/unit/UnitSilencer.h"
#include "device/drive/DriveSignal.h"

#include <algorithm>
#include <array>
#include <complex>
#include <cstdint>
#include <vector>

namespace midair::device::emulation
{

constexpr std::uint32_t kMostSlots = 1024;
constexpr std::uint32_t kMostSamples = 65536;

/// The part of a unit that plays: two banks of patterns, two of the modulation, silencer and
/// outputs. Times are readings of its clock, which never decrease but where that is set.
class UnitFpga
{
public:
    using WidthTable = std::array<std::uint16_t, 256>; ///< of 512 parts of the period

    /// Writes into what is heard, or is about to be.
    struct Intrusions
    {
        std::uint64_t banks = 0; ///< into a slot of the bank that plays or waits to
        std::uint64_t slots = 0; ///< into the very slot that was heard
    };

    UnitFpga() { clear(0); }

    void clear(Time_ns now_ns);            ///< all defaults, silence; slots beyond the first stay
    void restart() { *this = UnitFpga(); } ///< power off and on: nothing is left

    void writeSlot(int bank, std::uint32_t slot, const UnitPattern& pattern, Time_ns now_ns);
    void writeSamples(int bank,
                      std::uint32_t first,
                      const std::uint8_t* samples,
                      std::size_t count,
                      Time_ns now_ns);
    /// Writes the registers of a bank; they are looked at by the next activation.
    void configurePatterns(int bank, const BankRegisters& r) { _patterns.configure(bank, r); }
    void configureModulation(int bank, const BankRegisters& r) { _modulation.configure(bank, r); }
    Result activatePatterns(int bank,
                            Activation mode,
                            std::uint64_t value,
                            Time_ns now_ns,
                            Time_ns cpu_ns,
                            Time_ns margin_ns);
    Result activateModulation(int bank,
                              Activation mode,
                              std::uint64_t value,
                              Time_ns now_ns,
                              Time_ns cpu_ns,
                              Time_ns margin_ns);
    Result setSilencer(const UnitSilencer::Settings& settings, Time_ns now_ns);
    void setCorrection(const UnitLevels& levels, Time_ns now_ns);
    void setMask(const std::array<bool, kUnitTransducers>& on, Time_ns now_ns);
    void setWidths(const WidthTable& widths) { _widths = widths; }
    void setGate(bool closed, Time_ns now_ns); ///< closed: intensity 0, whatever is written

    /// Makes switches that are due by \a now_ns; true, once each, with what it was.
    bool takeSwitch(Time_ns now_ns, BankTimeline::Switch& made);
    Time_ns due_ns() const { return std::min(_patterns.due_ns(), _modulation.due_ns()); }

    const BankTimeline& patterns() const { return _patterns; }
    const BankTimeline& modulation() const { return _modulation; }
    const Intrusions& intrusions() const { return _intrusions; }
    bool gated() const { return _gated; }

    /// A number that stands for the whole cycle of the playing bank in our levels, without gate,
    /// modulation and silencer: contentOf() of its pattern if all slots are alike.
    std::uint64_t content() const;
    /// The slot that plays, in our levels, without gate, modulation and silencer.
    DriveSignal field(Time_ns now_ns) const;
    /// What the transducers put out, silencer and all, relative to full drive.
    std::vector<std::complex<float>> output(Time_ns now_ns);

private:
    UnitPattern slotOf(int bank, std::uint32_t slot) const;
    DriveSignal inOurLevels(const UnitPattern& pattern) const;
    UnitPattern target(Time_ns now_ns) const;
    std::uint8_t sampleAt(Time_ns now_ns) const;
    void render(Time_ns now_ns); ///< lets the silencer glide until now, with what played
    void lookAtModulation();
    int strictSteps(bool ofPatterns) const; ///< that dividers have to reach; 0: any will do

    std::array<std::vector<UnitPattern>, 2> _slots; ///< as many as were ever written
    std::array<std::vector<std::uint8_t>, 2> _samples;
    BankTimeline _patterns;
    BankTimeline _modulation;
    bool _steady = true; ///< all samples of the modulation that plays are alike
    UnitSilencer _silencer;
    Time_ns _rendered_ns = 0; ///< a period's edge
    UnitLevels _correction{};
    std::array<bool, kUnitTransducers> _on{};
    WidthTable _widths{};
    bool _gated = false;
    Intrusions _intrusions;
};

/// A number that stands for a unit's field in our levels; transducers that are off count alike.
std::uint64_t contentOf(const std::uint8_t* phase, const std::uint8_t* duty);

/// A number that stands for a cycle of fields: that of the field if all are alike.
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

/// The duty level of ours that a width, of 512 parts of the period, is nearest to.
std::uint8_t dutyOfWidth(std::uint16_t width);

} // namespace midair::device::emulation
