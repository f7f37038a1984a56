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

/// Lets all units go over to the other bank, at one time of their common clock or at once; and lets
/// all stay, if one of them may miss it.
class BankSwitch
{
public:
    /// \a fault gets the last thing that went wrong, as a sentence.
    BankSwitch(UnitGroup& group, const Autd3Options& options, Banks& banks, std::string& fault);

    /// Where a switch stands.
    enum class Stand
    {
        OPEN,     ///< not all have acknowledged it
        AGREED,   ///< all have; it takes place at its time (isPast())
        DONE,     ///< all have switched at once
        PUT_BACK, ///< a unit may miss it: all are told to stay (isSettled(), then isPast())
    };

    void start(bool atTime, double now_s);
    /// \a isRefused: a unit has refused something of this job. To be called until it isn't OPEN.
    Stand look(bool isRefused, double now_s);
    bool isSettled() const { return _open.none(); }
    /// Returns true once the time of the switch, or of the one back, is over.
    bool isPast(double now_s) const;
    double past_s() const;                                ///< when that will be
    double deadline_s() const { return _try.deadline_s; } ///< for look(), without an outcome
    /// Takes what became of a command; returns true if the unit refuses it for another reason than
    /// its time.
    bool take(const UnitGroup::Outcome& outcome);
    void forgetLost() { _open.forgetLost(); }
    /// A field was in time: the lead gets smaller.
    void calm();

    double sent_s() const { return _try.sent_s; } ///< when the last switch was sent
    std::uint64_t takenBack() const { return _takenBack; }
    std::uint64_t torn() const { return _torn; }
    double lead_s() const { return _lead_s; }

private:
    /// One switch of one job.
    struct Try
    {
        double deadline_s = 0; ///< for all to have acknowledged a timed switch
        double sent_s = 0;
        double time_ns = 0;     ///< of the switch, or of the latest one back
        bool isUnknown = false; ///< an answer was lost
        bool isLate = false;    ///< it was refused as too near
        bool isTorn = false;    ///< it is told that units differed
        bool isBack = false;    ///< it is being taken back
        /// Between when units have switched at once, of those that say so.
        std::uint64_t first_ns = 0;
        std::uint64_t last_ns = 0;
    };
    /// The way back.
    struct Back
    {
        double of_ns = 0;      ///< time of the switch that is taken back
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
    const double _margin_s; ///< the units' own
    OpenCommands _open;
    Try _try;
    Back _back;
    double _lead_s;             ///< grows when switches come too late
    std::uint64_t _repeats = 0; ///< of the group, as last seen
    double _lossy_s = -1;       ///< when they became more
    std::uint64_t _takenBack = 0;
    std::uint64_t _torn = 0;
};

} // namespace midair::device::autd3
