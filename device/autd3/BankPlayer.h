#pragma once

#include "device/autd3/Autd3Account.h"
#include "device/autd3/BankSwitch.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// Masks of all units, which silence them at once. While masked they receive a silent field; when
/// all play it, fail-safes are released and the masks lifted, inaudibly.
class UnitMasks
{
public:
    /// \a fault receives the last problem, as a sentence.
    UnitMasks(UnitGroup& group, const Autd3Options& options, std::string& fault);

    void cover(); ///< masks all units at once
    /// Notes that the fail-safe of \a unit has tripped and must be released before the masks are
    /// lifted.
    void noteTripped(int unit) { _isTripped[static_cast<std::size_t>(unit)] = true; }
    bool areOn() const { return _state != State::OFF; }
    /// Returns true if all present units have acknowledged the mask.
    bool areSilent() const { return areOn() && _open.none(); }

    /// Does what is due while no bank is being written; returns true if the silent field should be
    /// played now.
    bool step(double now_s);
    /// Time when step() is due without an outcome.
    double due_s() const { return areSilent() ? _again_s : UnitGroup::kNever_s; }
    void noteSilentField(bool isPlayed, double now_s);
    void take(const UnitGroup::Outcome& outcome);
    void forgetLost();

private:
    enum class State
    {
        OFF,
        ON,
        RELEASING, ///< a silent field plays; fail-safes are being released
        LIFTING
    };

    void push(int unit);
    void pushAll();

    UnitGroup& _group;
    const Autd3Options& _options;
    std::string& _fault;
    OpenCommands _open;
    State _state = State::OFF;
    std::vector<bool> _isTripped;
    double _again_s = 0; ///< earliest retry after a refused silent field or release
};

/// Plays fields on open units, so that all change together and none plays half a field.
///
/// A field is written into the idle bank of all units; when all have acknowledged it they are told
/// to switch at one time of their common clock. If one of them may miss the switch, the others are
/// told to stay. A silence is a mask, which acts at once; it is lifted when a silent field plays,
/// so that the next field begins on all units together.
///
/// A state machine of one thread: step() does what is due as outcomes of the group arrive.
class BankPlayer
{
public:
    /// Result of a job.
    enum class Fate
    {
        PLAYED,
        LOST,     ///< a unit refused it
        DISTURBED ///< not switched in time: all play the previous field; it may be retried
    };
    /// End of a job.
    struct Ending
    {
        std::shared_ptr<const Job> job;
        Fate fate = Fate::PLAYED;
        double handedOver_s = 0; ///< time when the last switch was sent
    };

    BankPlayer(UnitGroup& group, const Autd3Options& options);

    /// Returns true if start() may be called: no job in progress, no mask.
    bool isReady() const { return _stage == Stage::IDLE && !isMasked(); }
    void start(std::shared_ptr<const Job> job);
    /// Job in progress; null: none.
    const std::shared_ptr<const Job>& job() const { return _job; }
    /// Stops the upload of a sequence for a newer job; returns it, or null if there is none.
    std::shared_ptr<const Job> abandonSequence();

    /// Gives up the job in progress, on all units; returns it, or null if there is none.
    std::shared_ptr<const Job> cut();
    /// Masks all units at once, and drops the job in progress; returns it.
    std::shared_ptr<const Job> silence();
    /// Returns true while units are masked.
    bool isMasked() const { return _masks.areOn(); }
    /// Returns true if all present units have acknowledged the mask.
    bool isSilent() const { return _masks.areSilent(); }

    /// Handles a tripped fail-safe: silences all units, and releases it when a silent field plays.
    std::shared_ptr<const Job> release(int unit);

    /// Processes the outcome of a command, and does what is due.
    void take(const UnitGroup::Outcome& outcome);
    void step(double now_s);
    /// Time when step() is due without an outcome.
    double due_s() const;

    std::vector<Ending> takeEndings() { return std::exchange(_endings, {}); }
    /// Takes the last refusal of a unit, as a sentence; empty: none.
    std::string takeFault() { return std::exchange(_fault, {}); }

    std::uint64_t takenBack() const { return _switch.takenBack(); } ///< switches taken back
    /// Switches of which a unit may have played alone for a while, according to its answers.
    std::uint64_t torn() const { return _switch.torn(); }
    /// Increases when switches come too late; two round trips are added.
    double lead_s() const { return _switch.lead_s(); }

private:
    enum class Stage
    {
        IDLE,
        WRITING,     ///< into the idle bank
        SWITCHING,   ///< the switch is sent
        WAITING,     ///< for the time of the switch
        TAKING_BACK, ///< the switch back is sent
        STAYING      ///< until the time of the switch back
    };
    void end(Fate fate, double now_s);
    void endRefused(double now_s);
    void stepStage(double now_s);
    void noteRefusal(const UnitGroup::Outcome& outcome);

    UnitGroup& _group;
    const Autd3Options& _options;
    const std::shared_ptr<const Job> _silentJob;
    std::string _fault;
    Banks _banks;
    BankWriter _writer;
    BankSwitch _switch;
    UnitMasks _masks;
    Stage _stage = Stage::IDLE;
    std::shared_ptr<const Job> _job;
    bool _isCut = false;  ///< the job was silenced or given up
    std::string _refusal; ///< last refusal of the job, other than for its time
    std::vector<Ending> _endings;
};

} // namespace midair::device::autd3
