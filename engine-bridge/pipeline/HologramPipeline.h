#pragma once

#include "engine-bridge/hands/HandsAndObstacles.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/PlayedFieldMonitor.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "engine-bridge/playing/EarWatch.h"
#include "engine-bridge/playing/PressureCap.h"
#include "engine-bridge/rendering/ContactRenderer.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"

#include <atomic>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Takes a snapshot to the array, in one thread: assemble (sample, pose and select points) ->
/// compose (solve for the fields) -> cap (limit the pressure at the points) -> play.
///
/// process() throws for no content of a snapshot: an object that can't be felt is left out with a
/// message, and if the field can't be computed the array falls silent. Each message is logged once.
class HologramPipeline
{
public:
    /// Throws base::InputError if the options are not valid. A device that can't be opened is a
    /// message; fields are then solved and shown, but not played.
    explicit HologramPipeline(HologramOptions options);

    HologramPipeline(const HologramPipeline&) = delete;
    HologramPipeline& operator=(const HologramPipeline&) = delete;

    /// Returns the field for \a snapshot, or the last one again if nothing moved by more than the
    /// tolerance. Never null. \a superseded is the number of snapshots that were dropped for this
    /// one; it goes into the counters only.
    std::shared_ptr<const HologramResult> process(const SceneSnapshot& snapshot,
                                                  std::uint64_t superseded = 0);

    /// To be called while no snapshot comes: resends a field that the device has lost, makes the
    /// next step of what RestRefiner has left to do and plays it, and reports what the monitor
    /// found. Returns null if nothing changed.
    std::shared_ptr<const HologramResult> attend();
    /// The longest time until attend() should be called again, s; 0: there is work left.
    double rest_s() const;
    /// Interval at which the device of a still scene is checked: after at most this time a field
    /// that it lost is resent.
    static constexpr double kAttend_s = 0.5; // a check costs some 50 us, most of it waking up

    /// Silences the array until the next process(), which solves even if nothing moved.
    void silence() { _output->silence(ArrayOutput::Silence::FAILED); }

    /// Works with \a options from the next process() on, which solves even if nothing moved. Array,
    /// device, their factory and the owner stay those that it was made with; the device stays
    /// open, the last field stays the start of the next one where the solver allows it, counters
    /// and messages go on. A stricter cap silences what is played until that process(). Options
    /// that are not valid are a message, and nothing is played until there are others.
    void reconfigure(HologramOptions options);

    /// The part of reconfigure() that can't wait: returns true if the caps in \a options are so
    /// strict that what is played, or being solved, may exceed them. Any thread.
    bool isStricter(const HologramOptions& options) const;
    /// Lowers the cap of the amplitude at once. Any thread.
    void lowerAmplitudeCap(double amplitude) { _output->lowerAmplitudeCap(amplitude); }
    /// See ArrayOutput. Any thread.
    void setMuted(bool muted) { _output->setMuted(muted); }

    /// See ArrayOutput. To be called before the first process().
    void follow(const std::shared_ptr<device::Lead>& lead) { _output->follow(lead); }

    /// To be called before the first process(). Once \a stop is requested, process() and attend()
    /// return within milliseconds and send nothing more: process() returns a silent result that
    /// says STOPPED, attend() null.
    void setStop(const base::StopToken& stop);
    /// Silences the array. May be called from any thread, also during process(); a field that
    /// process() is working on may still be played afterwards, unless a stop was requested before.
    void silenceNow() { _output->silenceNow(); }

    /// To be called between the calls of process(). Returns true if a device that could not be
    /// opened is open now: then the last snapshot should be processed again, which plays it.
    bool isOpenedNow();

    const HologramCounters& counters() const { return _counters; }
    const HologramOptions& options() const { return _options; }
    ArrayFields fields() const { return _output->fields(); }       ///< any thread
    std::string deviceStatus() const { return _output->status(); } ///< any thread
    ArrayReading reading() const { return _output->reading(); }    ///< any thread
    /// When the solver has begun with the field that it is at work on, s on the steady clock; 0: it
    /// isn't. Any thread.
    double solvingSince_s() const { return _composer->busySince_s(); }
    /// What a simulated device has played in the last \a duration_s (0 .. 0.1). Any thread.
    PlayedDrives playedOfLate(double duration_s) const { return _output->playedOfLate(duration_s); }
    haptics::ExposureFigures exposure() const; ///< as of now; any thread
    std::vector<std::string> messages() const { return _messages.all(); }

private:
    static constexpr double kMonitorPoll_s = 0.02; // interval of attend() while the monitor works

    void tellOfDeath();
    void tellReport(const haptics::ControlPoints& points, haptics::FieldSequence& sequence);
    void openOutput();
    void useAbility();
    void useParts(bool otherSolver);
    std::shared_ptr<HologramResult> begin(const SceneSnapshot& snapshot) const;
    void keepArray(const haptics::TransducerArray& array, HologramResult& result) const;
    void setCaps();
    void setEars();
    bool hasMovedEars(const SceneSnapshot& snapshot);
    PointAssembler::Options assemblerOptions() const;
    haptics::ComposerOptions lineOptions() const;
    void useOptions(HologramOptions options);
    void makeContacts();
    const SceneSnapshot& shared(const SceneSnapshot& snapshot);
    bool rendersContacts() const;
    double contactPeriod_s() const;
    std::shared_ptr<const HologramResult> playContacts(std::shared_ptr<HologramResult> result);
    std::shared_ptr<const HologramResult> attendContacts();
    std::shared_ptr<const HologramResult> playWhole();
    std::shared_ptr<const HologramResult> solveAndPlay(const SceneSnapshot& snapshot);
    std::shared_ptr<const HologramResult>
    silent(const SceneSnapshot& snapshot, haptics::StopReason stop, const std::string& why);
    std::shared_ptr<const HologramResult> lookAfterDevice();
    bool isMeasured() const;
    std::shared_ptr<const HologramResult> refine();
    std::shared_ptr<const HologramResult> askMonitor();

    haptics::ControlPoints assemble(const SceneSnapshot& snapshot, int set, HologramResult& result);
    haptics::FieldSequence compose(const SceneSnapshot& snapshot,
                                   int set,
                                   const haptics::ControlPoints& points,
                                   const haptics::TransducerArray& array);
    void continueLast(haptics::FieldSequence& sequence) const;
    void cap(const haptics::TransducerArray& array,
             haptics::FieldSequence& sequence,
             HologramResult& result);
    PressureCap::Where
    where(const haptics::TransducerArray& array, const Eigen::Matrix3Xd& points, bool modulated);
    void tellOfSilence(const PressureCap::Where& where,
                       const std::vector<Eigen::VectorXcf>& wanted,
                       haptics::SolveReport& report);
    void play(haptics::FieldSequence sequence, HologramResult& result);
    void measure(const haptics::TransducerArray& array, HologramResult& result);
    void rateFromLast(HologramResult& result) const;
    bool isPlayedAlready(const haptics::FieldSequence& sequence,
                         const haptics::ControlPoints& points) const;
    void playOn(const haptics::FieldSequence& sequence,
                haptics::ControlPoints points,
                const haptics::TransducerArray& array,
                HologramResult& result);
    ArrayState stateOf(const HologramResult& result);
    void finish(HologramResult& result, bool isOtherField = true);

    HologramOptions _options;
    std::shared_ptr<const haptics::TransducerArray> _array; // that of _options, for the results
    base::MessageLog _messages;
    std::unique_ptr<ArrayOutput> _output;
    std::unique_ptr<PressureCap> _cap; // of the highest pressure there is, if there is no cap
    bool _capped = false;              // there is a cap
    std::atomic<double> _cap_Pa{0.0};  // its pressure; 0: none
    std::string _capName;              // the setting that it comes from
    bool _silenceTold = false;
    EarWatch _ears;
    bool _isDead = false; // no transducer of the array sounds
    haptics::LineRate _line;
    std::unique_ptr<PointAssembler> _assembler;
    std::unique_ptr<haptics::SequenceComposer> _composer;
    std::unique_ptr<RestRefiner> _refiner;
    std::unique_ptr<PlayedFieldMonitor> _monitor;
    std::unique_ptr<ContactRenderer> _contacts;
    SceneSnapshot _shared;         // the newest, with the objects' shares
    bool _hasContacts = false;     // its objects may be felt by contacts
    bool _playsContacts = false;   // what is played has contacts
    haptics::FieldSequence _whole; // of the whole objects, before caps; kept where contacts may be
    double _contactField_s = 0.0;  // steady clock, when the last one was played
    double _contactShown_s = 0.0;  // when the last one was published
    ReachAndShadow _around;
    HologramCounters _counters;
    std::shared_ptr<const HologramResult> _last;
    bool _changed = false;    // the options have changed since _last
    bool _earsMoved = false;  // since then, where a limit holds for them
    CappedDrives _proven;     // by the last cap(), which play() sends; without drives: not capped
    Eigen::VectorXcf _solved; // what _last was made of, before caps; empty: of something else
    std::string _invalid;     // what is wrong with the options; empty: nothing
    UpdateRate _updates;
};

} // namespace midair::bridge
