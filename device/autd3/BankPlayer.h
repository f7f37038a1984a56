#pragma once

#include "device/autd3/Autd3Account.h"
#include "device/autd3/BankSwitch.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// The masks of all units, which silence them at once. Masked, they are given a silent field; when
/// that plays on all, fail-safes are released and the masks are lifted, which nobody hears.
class UnitMasks
{
public:
    /// \a fault gets the last thing that went wrong, as a sentence.
    UnitMasks(UnitGroup& group, const Autd3Options& options, std::string& fault);

    void cover(); ///< all units, at once
    /// The fail-safe of \a unit has tripped, and is to be released before the masks are lifted.
    void noteTripped(int unit) { _isTripped[static_cast<std::size_t>(unit)] = true; }
    bool areOn() const { return _state != State::OFF; }
    /// Returns true if all units that are there have acknowledged the mask.
    bool areSilent() const { return areOn() && _open.none(); }

    /// Does what is due while nothing is on its way to the banks; returns true if the silent field
    /// is to be played now.
    bool step(double now_s);
    /// When step() has something to do without an outcome.
    double due_s() const { return areSilent() ? _again_s : UnitGroup::kNever_s; }
    void noteSilentField(bool isPlayed, double now_s);
    void take(const UnitGroup::Outcome& outcome);
    void forgetLost();

private:
    enum class State
    {
        OFF,
        ON,
        RELEASING, ///< a silent field plays; fail-safes are released
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
    double _again_s = 0; ///< not before: a silent field, or a release, was refused
};

/// Plays fields on open units, so that all of them change together and none plays half a field.
///
/// A field is written into the bank that doesn't play, on all units; once all have acknowledged it
/// they are told to switch, at one time of their common clock. If one of them may miss that, the
/// others are told to stay. A silence is a mask, which acts at once; it is lifted when a silent
/// field plays, so that what follows begins on all units together again.
///
/// A state machine of one thread: step() does what is due, as outcomes of the group come in.
class BankPlayer
{
public:
    /// What became of a job.
    enum class Fate
    {
        PLAYED,
        LOST,     ///< a unit refused it
        DISTURBED ///< not switched to in time: all play what they did; it may be tried again
    };
    /// An end of a job.
    struct Ending
    {
        std::shared_ptr<const Job> job;
        Fate fate = Fate::PLAYED;
        double handedOver_s = 0; ///< when the last switch was sent
    };

    BankPlayer(UnitGroup& group, const Autd3Options& options);

    /// Returns true if start() may be called: nothing is on its way, nothing is masked.
    bool isReady() const { return _stage == Stage::IDLE && !isMasked(); }
    void start(std::shared_ptr<const Job> job);
    /// The job on its way; null: none.
    const std::shared_ptr<const Job>& job() const { return _job; }
    /// Stops the upload of a sequence for something newer; returns it, or null if there is none.
    std::shared_ptr<const Job> abandonSequence();

    /// Gives the job on its way up, at no unit half; returns it, or null if there is none.
    std::shared_ptr<const Job> cut();
    /// Masks all units at once, and drops the job on its way; returns it.
    std::shared_ptr<const Job> silence();
    /// Returns true while units are masked.
    bool isMasked() const { return _masks.areOn(); }
    /// Returns true if all units that are there have acknowledged the mask.
    bool isSilent() const { return _masks.areSilent(); }

    /// A unit's fail-safe has tripped: silences all, and releases it once a silent field plays.
    std::shared_ptr<const Job> release(int unit);

    /// Takes what became of commands, and does what is due.
    void take(const UnitGroup::Outcome& outcome);
    void step(double now_s);
    /// When step() has something to do without an outcome.
    double due_s() const;

    std::vector<Ending> takeEndings() { return std::exchange(_endings, {}); }
    /// The last refusal of a unit, as a sentence, moved out; empty: none.
    std::string takeFault() { return std::exchange(_fault, {}); }

    std::uint64_t takenBack() const { return _switch.takenBack(); } ///< switches that were
    /// Switches of which a unit may have played alone for a while, as its answers say.
    std::uint64_t torn() const { return _switch.torn(); }
    /// Grows when switches come too late; two round trips come on top.
    double lead_s() const { return _switch.lead_s(); }

private:
    enum class Stage
    {
        IDLE,
        WRITING,     ///< into the bank that doesn't play
        SWITCHING,   ///< the switch is sent
        WAITING,     ///< for the time of the switch
        TAKING_BACK, ///< the switch back is sent
        STAYING      ///< until the time of that
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
    std::string _refusal; ///< the last one of the job, but for its time
    std::vector<Ending> _endings;
};

} // namespace midair::device::autd3
