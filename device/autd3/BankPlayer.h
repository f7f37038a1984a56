#pragma once

#include "device/autd3/Autd3Options.h"
#include "device/autd3/UnitGroup.h"
#include "device/drive/DriveSignal.h"

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// A field, or a sequence of fields, for all units.
struct Job
{
    std::vector<DriveSignal> signals; ///< at least one; one: a field that stands
    int divider = 1;                  ///< of a sequence: a field lasts divider x 25 us
    double sentAt_s = 0;              ///< steady clock, at send()

    bool isSequence() const { return signals.size() > 1; }
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
    void start(std::shared_ptr<const Job> job) { begin(std::move(job)); }
    /// The job on its way; null: none.
    const std::shared_ptr<const Job>& job() const { return _job; }
    /// Stops the upload of a sequence for something newer; returns it, or null if there is none.
    std::shared_ptr<const Job> abandonSequence();

    /// Gives the job on its way up, at no unit half; returns it, or null if there is none.
    std::shared_ptr<const Job> cut();
    /// Masks all units at once, and drops the job on its way; returns it.
    std::shared_ptr<const Job> silence();
    /// Returns true while units are masked.
    bool isMasked() const { return _mask != Mask::OFF; }
    /// Returns true if all units that are there have acknowledged the mask.
    bool isSilent() const { return isMasked() && _maskOpen.none(); }

    /// A unit's fail-safe has tripped: silences all, and releases it once a silent field plays.
    std::shared_ptr<const Job> release(int unit);

    /// Takes what became of commands, and does what is due.
    void take(const UnitGroup::Outcome& outcome);
    void step(double now_s);
    /// When step() has something to do without an outcome.
    double due_s() const;

    std::vector<Ending> takeEndings();
    /// The last refusal of a unit, as a sentence, moved out; empty: none.
    std::string takeFault();

    std::uint64_t takenBack() const { return _takenBack; } ///< switches that were
    /// Switches of which a unit may have played alone for a while, as its answers say.
    std::uint64_t torn() const { return _torn; }
    /// Grows when switches come too late; two round trips come on top.
    double lead_s() const { return _lead_s; }

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
    enum class Mask
    {
        OFF,
        ON,
        RELEASING, ///< a silent field plays; fail-safes are released
        LIFTING
    };

    /// Commands that are not settled, of each unit.
    struct OpenCounts
    {
        std::array<int, kMostUnits> count{};
        std::uint64_t total = 0;
        void add(int unit) { ++count[static_cast<std::size_t>(unit)], ++total; }
        void settle(int unit, int commands);
        void forget(int unit) { settle(unit, of(unit)); }
        void clear() { *this = {}; }
        bool none() const { return total == 0; }
        int of(int unit) const { return count[static_cast<std::size_t>(unit)]; }
    };

    void
    push(OpenCounts& counts, int unit, const Command& command, double repeat_s, int copies = 1);
    int switchCopies(double now_s);
    double soon_s(double pause_s) const;
    void noteSwitch(std::uint64_t time_ns);
    void tellTorn(const std::string& what);
    void begin(std::shared_ptr<const Job> job);
    void end(Fate fate, double now_s);
    void forgetLost();
    void takeStaged(const UnitGroup::Outcome& outcome);
    void stepStage(double now_s);

    void configure(const BankConfig& config);
    void feed();
    bool feed(int unit);
    bool isWritten() const;
    Command piece(int unit, int first, int& count);
    void endWriting(double now_s);

    void switchAtTime(double now_s);
    void switchAtOnce(double now_s);
    void endSwitching(double now_s);
    void takeBack(double now_s);
    void pushTakeBack(int unit, double now_s);
    void takeSwitchBack(const UnitGroup::Outcome& outcome);

    void takeMasking(const UnitGroup::Outcome& outcome);
    void stepMask(double now_s);
    void pushMask(int unit);

    UnitGroup& _group;
    const Autd3Options& _options;
    const double _margin_s;
    Stage _stage = Stage::IDLE;
    OpenCounts _open; ///< of the stage
    std::shared_ptr<const Job> _job;
    const std::shared_ptr<const Job> _silentJob;
    /// What one unit has of the job.
    struct Written
    {
        int next = 0;           ///< the slot that is written next
        std::deque<int> sent;   ///< first slots of the frames that are not settled; kConfigPiece
        std::vector<int> again; ///< of those whose result was lost
    };
    static constexpr int kConfigPiece = -1; ///< the settings of the bank, in place of slots
    std::vector<Written> _written;
    int _slots = 0; ///< that are written
    int _bank = 0;  ///< that is written, or switched to
    int _playing = 0;
    /// As all units have them; nullopt: not known.
    std::array<std::optional<BankConfig>, kBanks> _configs;
    std::vector<UnitPattern> _patterns;
    bool _isCut = false;     ///< the job was silenced or given up
    bool _isUnknown = false; ///< an answer of this stage was lost
    bool _isTorn = false;    ///< it is told that units differed
    bool _isLate = false;    ///< a switch of this stage was refused as too near
    std::string _refusal;    ///< the last other one of this stage

    double _lead_s;
    std::uint64_t _repeats = 0; ///< of the group, as last seen
    double _lossy_s = -1;       ///< when they became more
    /// Between when units have switched at once, of those that say so.
    std::uint64_t _first_ns = 0;
    std::uint64_t _last_ns = 0;
    double _deadline_s = 0;   ///< for all to have acknowledged a timed switch
    double _sent_s = 0;       ///< when the switch was sent
    double _time_ns = 0;      ///< of the switch, or of the latest one back
    double _takenBack_ns = 0; ///< time of the switch that is taken back
    std::vector<int> _backs;  ///< switches back that were sent to each unit for one

    Mask _mask = Mask::OFF;
    OpenCounts _maskOpen;
    std::vector<bool> _isTripped;
    double _maskAgain_s = 0; ///< not before: a silent field, or a release, was refused

    std::vector<Ending> _endings;
    std::string _fault;
    std::uint64_t _takenBack = 0;
    std::uint64_t _torn = 0;
};

} // namespace midair::device::autd3
