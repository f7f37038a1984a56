#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"

#include <array>
#include <cstdint>

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

/// How an activation names its time.
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

/// Which of two banks plays, and which of its slots: of patterns, or of the modulation. Times are
/// readings of the FPGA's clock, but for the margin, which the CPU checks by its own.
class BankTimeline
{
public:
    /// A switch that has come about.
    struct Switch
    {
        Time_ns at_ns = 0; ///< the period's edge from which the bank is heard
        int bank = 0;
        bool replays = false; ///< the bank that played before plays again
    };

    void clear(std::uint32_t slots); ///< bank 0 plays for ever, both with \a slots
    void configure(int bank, const BankRegisters& registers) { _written[bank] = registers; }

    /// What an activation is refused for.
    struct Rules
    {
        Time_ns margin_ns = 0; ///< how near a switch may be
        int steps = 0;         ///< that the dividers of banks that are heard have to reach
    };
    /// Plans a switch, or makes it (NOW), and makes the registers of both banks valid.
    Result activate(int bank,
                    Activation mode,
                    std::uint64_t value,
                    Time_ns fpga_ns,
                    Time_ns cpu_ns,
                    const Rules& rules);
    /// Returns true if the dividers of the banks that are heard, or will be, reach \a steps.
    bool reaches(int steps) const;

    bool waits() const { return _waits; }
    Time_ns due_ns() const { return _waits ? _due_ns : kNever_ns; }
    /// Makes the switch that waits if it is due by \a fpga_ns, or one that was made at once; true,
    /// once, with what it was.
    bool takeSwitch(Time_ns fpga_ns, Switch& made);

    int bank() const { return _bank; }
    int waitingBank() const { return _requested; } ///< the playing one if none waits
    bool forEver() const { return _forEver; }
    const BankRegisters& playing() const { return _valid[_bank]; }
    const BankRegisters& valid(int bank) const { return _valid[bank]; }
    const BankRegisters& written(int bank) const { return _written[bank]; }
    std::uint32_t slotAt(Time_ns fpga_ns) const;
    bool endedAt(Time_ns fpga_ns) const; ///< its rounds are played, the last slot stands

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

} // namespace midair::device::emulation
