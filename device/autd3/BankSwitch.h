#pragma once

#include "device/autd3/Autd3Account.h"
#include "device/autd3/Autd3Options.h"
#include "device/autd3/UnitGroup.h"

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// The two pattern banks, identical on all units. After Clear bank 0 plays its one slot, which is
/// zero. The other contents are unknown, so a bank is configured only while idle.
struct Banks
{
    int playing = 0;
    std::array<std::optional<BankConfig>, kBanks> configs{BankConfig{}, std::nullopt};

    int other() const { return 1 - playing; } ///< for writing or switching
    std::optional<BankConfig>& config(int bank) { return configs[static_cast<std::size_t>(bank)]; }
};

/// Counts unsettled commands per unit.
class OpenCommands
{
public:
    explicit OpenCommands(UnitGroup& group) : _group(group) {}

    /// Sends a command if the unit is present.
    void push(int unit, const Command& command, double repeat_s, int copies = 1);
    void settle(int unit, int commands = 1);
    void forgetLost(); ///< commands to lost units
    bool none() const { return _total == 0; }
    int of(int unit) const { return _count[static_cast<std::size_t>(unit)]; }

private:
    UnitGroup& _group;
    std::array<int, kMostUnits> _count{};
    std::uint64_t _total = 0;
};

/// Writes a job into the idle bank of all units at once, as fast as their windows accept it. Pieces
/// that are not confirmed are written again.
class BankWriter
{
public:
    BankWriter(UnitGroup& group, const Autd3Options& options, Banks& banks);

    void begin(const Job& job);
    /// Fills the units' windows; encodes only what they accept.
    void feed(const Job& job);
    /// Drops unsent frames; the bank's contents are then unknown.
    void cut();
    /// Returns true if nothing is in flight.
    bool isSettled() const { return _open.none(); }
    /// Returns true if all units have acknowledged the whole job.
    bool isWritten() const;
    /// Processes the outcome of a command; returns true if the unit refuses it.
    bool take(const UnitGroup::Outcome& outcome);
    void forgetLost() { _open.forgetLost(); }

private:
    /// Progress of one unit.
    struct Written
    {
        int next = 0;           ///< next slot to write
        std::deque<int> sent;   ///< first slots of unsettled frames; kConfigPiece
        std::vector<int> again; ///< first slots of frames with lost results
    };
    static constexpr int kConfigPiece = -1; ///< the settings of the bank, instead of slots

    bool feed(int unit, const Job& job);
    Command piece(int unit, const Job& job, int first, int& count);

    UnitGroup& _group;
    const Autd3Options& _options;
    Banks& _banks;
    OpenCommands _open;
    std::vector<Written> _written;
    int _slots = 0; ///< slots to write
    std::vector<UnitPattern> _patterns;
};

/// Switches all units to the other bank, at one time of their common clock or at once, and makes
/// all stay if one of them may miss it.
class BankSwitch
{
public:
    /// \a fault receives the last problem, as a sentence.
    BankSwitch(UnitGroup& group, const Autd3Options& options, Banks& banks, std::string& fault);

    /// State of a switch.
    enum class Stand
    {
        OPEN,     ///< not acknowledged by all
        AGREED,   ///< acknowledged by all; takes place at its time (isPast())
        DONE,     ///< all have switched at once
        PUT_BACK, ///< a unit may miss it: all are told to stay (isSettled(), then isPast())
    };

    void start(bool atTime, double now_s);
    /// \a isRefused: a unit has refused a part of this job. Call it until it isn't OPEN.
    Stand look(bool isRefused, double now_s);
    bool isSettled() const { return _open.none(); }
    /// Returns true after the time of the switch, or of the switch back.
    bool isPast(double now_s) const;
    double past_s() const;                                ///< time when isPast() becomes true
    double deadline_s() const { return _try.deadline_s; } ///< for look(), without an outcome
    /// Processes the outcome of a command; returns true if the unit refuses it for another reason
    /// than its time.
    bool take(const UnitGroup::Outcome& outcome);
    void forgetLost() { _open.forgetLost(); }
    /// Reports a field in time: reduces the lead.
    void calm();

    double sent_s() const { return _try.sent_s; } ///< time when the last switch was sent
    std::uint64_t takenBack() const { return _takenBack; }
    std::uint64_t torn() const { return _torn; }
    double lead_s() const { return _lead_s; }

private:
    /// One switch of one job.
    struct Try
    {
        double deadline_s = 0; ///< for all acknowledgements of a timed switch
        double sent_s = 0;
        double time_ns = 0;     ///< of the switch, or of the latest switch back
        bool isUnknown = false; ///< an answer was lost
        bool isLate = false;    ///< it was refused as too close
        bool isTorn = false;    ///< units are reported to differ
        bool isBack = false;    ///< it is being taken back
        /// Range of times at which units switched at once, as far as reported.
        std::uint64_t first_ns = 0;
        std::uint64_t last_ns = 0;
    };
    /// The switch back.
    struct Back
    {
        double of_ns = 0;      ///< time of the original switch
        std::vector<int> sent; ///< switches back to each unit
    };

    void startAtTime(double now_s);
    void sendAtOnce(double now_s);
    bool isTimed() const;
    void takeBack(bool isRefused, double now_s);
    void pushBack(int unit, double now_s);
    void takeOneBack(const UnitGroup::Outcome& outcome);
    int copies(double now_s);
    void tellTorn(const std::string& what);

    UnitGroup& _group;
    const Autd3Options& _options;
    Banks& _banks;
    std::string& _fault;
    const double _margin_s; ///< of the units
    OpenCommands _open;
    Try _try;
    Back _back;
    double _lead_s;             ///< increases when switches come too late
    std::uint64_t _repeats = 0; ///< of the group, as last seen
    double _lossy_s = -1;       ///< time of their last increase
    std::uint64_t _takenBack = 0;
    std::uint64_t _torn = 0;
};

} // namespace midair::device::autd3
