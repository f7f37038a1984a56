#pragma once

#include "device/autd3/Autd3Options.h"
#include "device/autd3/Job.h"
#include "device/autd3/UnitGroup.h"

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

namespace midair::device::autd3
{

/// The two banks of patterns, which all units have alike. After Clear bank 0 plays its one slot,
/// which is zero. What else it holds nobody knows, so it gets its settings only when it doesn't
/// play.
struct Banks
{
    int playing = 0;
    std::array<std::optional<BankConfig>, kBanks> configs{BankConfig{}, std::nullopt};

    int other() const { return 1 - playing; } ///< that is written, or switched to
    std::optional<BankConfig>& config(int bank) { return configs[static_cast<std::size_t>(bank)]; }
};

/// Commands to units that are not settled, counted for each unit.
class OpenCommands
{
public:
    explicit OpenCommands(UnitGroup& group) : _group(group) {}

    /// Sends a command, if the unit is there.
    void push(int unit, const Command& command, double repeat_s, int copies = 1);
    void settle(int unit, int commands = 1);
    void forgetLost(); ///< what was sent to units that are lost
    bool none() const { return _total == 0; }
    int of(int unit) const { return _count[static_cast<std::size_t>(unit)]; }

private:
    UnitGroup& _group;
    std::array<int, kMostUnits> _count{};
    std::uint64_t _total = 0;
};

/// Writes a job into the bank that doesn't play, on all units at once, as fast as their windows
/// take it. What isn't known to be there is written once more.
class BankWriter
{
public:
    BankWriter(UnitGroup& group, const Autd3Options& options, Banks& banks);

    void begin(const Job& job);
    /// Keeps the units' windows full; no more is encoded than they take.
    void feed(const Job& job);
    /// Takes back what isn't sent: the bank holds nothing that is known.
    void cut();
    /// Returns true if nothing is on its way.
    bool isSettled() const { return _open.none(); }
    /// Returns true if all units have acknowledged all of it.
    bool isWritten() const;
    /// Takes what became of a command; returns true if the unit refuses it.
    bool take(const UnitGroup::Outcome& outcome);
    void forgetLost() { _open.forgetLost(); }

private:
    /// What one unit has of the job.
    struct Written
    {
        int next = 0;           ///< the slot that is written next
        std::deque<int> sent;   ///< first slots of the frames that are not settled; kConfigPiece
        std::vector<int> again; ///< of those whose result was lost
    };
    static constexpr int kConfigPiece = -1; ///< the settings of the bank, in place of slots

    bool feed(int unit, const Job& job);
    Command piece(int unit, const Job& job, int first, int& count);

    UnitGroup& _group;
    const Autd3Options& _options;
    Banks& _banks;
    OpenCommands _open;
    std::vector<Written> _written;
    int _slots = 0; ///< that are written
    std::vector<UnitPattern> _patterns;
};

} // namespace midair::device::autd3
