#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"
#include "device/drive/DriveSignal.h"

#include <cstdint>
#include <deque>
#include <vector>

namespace midair::device::emulation
{

/// Observations of fields on all units together.
struct FieldWatchReport
{
    std::uint64_t whole = 0; ///< changes that all units made together
    /// Changes that left units with different fields for longer than the tolerance, including one
    /// that continues.
    std::uint64_t torn = 0;
    Time_ns longestTear_ns = 0;
    Time_ns worstSkew_ns = 0;        ///< from first to last unit, for whole changes
    std::uint64_t unknown = 0;       ///< changes of a unit to a field that nobody sent, if known
    std::uint64_t lastNumber = 0;    ///< of the field on all units, if fields are known
    std::uint64_t numbersPlayed = 0; ///< different ones of them
};

/// Watches the units' fields and detects torn ones: some units play one, some another.
///
/// With expect() for all sent fields, it compares what units play. Otherwise all units must switch
/// once within the tolerance. Units that are off, cleared, or closed by failsafe or mask are
/// ignored until they play again.
class FieldWatch
{
public:
    /// \a tolerance_ns: longest duration of a change, >= 0; a period and the clocks' difference for
    /// timed switches.
    FieldWatch(int units, Time_ns tolerance_ns);

    /// Field \a number (> 0, ascending) may play from now on. The newest 256 are known, and
    /// silence, which is number 0.
    void expect(std::uint64_t number, const DriveSignal& signal);
    void expect(std::uint64_t number, const std::vector<DriveSignal>& cycle);

    void switched(int unit, Time_ns at_ns, std::uint64_t content, bool replays);
    void changed(int unit, Time_ns at_ns, std::uint64_t content); ///< without a switch
    void cleared(int unit, Time_ns at_ns, std::uint64_t content);
    void rebooted(int unit, Time_ns at_ns, std::uint64_t content);
    void closed(int unit, Time_ns at_ns, bool isClosed); ///< by failsafe or mask

    FieldWatchReport report(Time_ns now_ns) const;

private:
    enum class Light
    {
        LIT,
        CLEARED, ///< silent until the next field, anywhere
        OFF      ///< silent until its own
    };
    /// A unit as observed.
    struct Seen
    {
        std::uint64_t content = 0;
        Light light = Light::CLEARED;
        bool closed = false;
        bool switched = false; ///< in the present change
        bool missed = false;   ///< a change, while it was closed

        bool counts() const { return light == Light::LIT && !closed; }
    };
    /// A field that may play: its number and what each unit has of it.
    struct Expected
    {
        std::uint64_t number;
        std::vector<std::uint64_t> contents;
    };

    void look(Time_ns at_ns);
    void lookBySwitches(Time_ns at_ns, bool again);
    void begin(Time_ns at_ns);
    void end(Time_ns at_ns);
    bool known(int unit, std::uint64_t content) const;
    /// Returns the field of all counting units; null if they differ.
    const Expected* together() const;

    const Time_ns _tolerance_ns;
    std::vector<Seen> _units;
    Expected _silence;
    std::deque<Expected> _expected;
    bool _changing = false; ///< units differ
    Time_ns _since_ns = 0;
    std::uint64_t _newest = 0;
    FieldWatchReport _report;
};

} // namespace midair::device::emulation
