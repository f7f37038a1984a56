#pragma once

#include "engine-bridge/pipeline/CappedOutput.h"
#include "engine-bridge/pipeline/ContactStage.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/PlayedFieldMonitor.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "haptics/sequence/SequenceComposer.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Takes a snapshot to the array, in one thread: assemble (sample, pose and select points) ->
/// compose (solve for the fields) -> cap (limit the pressure at the points) -> play. Hands, ears,
/// contacts, what refines and what measures accompany it as stages.
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
    void silence() { _output.silence(); }

    /// Works with \a options from the next process() on, which solves even if nothing moved. Array,
    /// device, their factory and the owner stay those that it was made with; the device stays
    /// open, the last field stays the start of the next one where the solver allows it, counters
    /// and messages go on. A stricter cap silences what is played until that process(). Options
    /// that are not valid are a message, and nothing is played until there are others.
    void reconfigure(HologramOptions options);

    /// The part of reconfigure() that can't wait: returns true if the caps in \a options are so
    /// strict that what is played, or being solved, may exceed them. Any thread.
    bool isStricter(const HologramOptions& options) const { return _output.isStricter(options); }
    /// The array. What of it is for any thread may be called during process(), too: a field that
    /// process() is working on may still be played after its silenceNow(), unless a stop was
    /// requested before.
    ArrayOutput& device() { return _output.device(); }
    const ArrayOutput& device() const { return _output.device(); }

    /// To be called before the first process(). Once \a stop is requested, process() and attend()
    /// return within milliseconds and send nothing more: process() returns a silent result that
    /// says STOPPED, attend() null.
    void setStop(const base::StopToken& stop);

    /// To be called between the calls of process(). Returns true if a device that could not be
    /// opened is open now: then the last snapshot should be processed again, which plays it.
    bool isOpenedNow();

    const HologramCounters& counters() const { return _context.counters; }
    const HologramOptions& options() const { return _context.options; }
    /// When the solver has begun with the field that it is at work on, s on the steady clock; 0: it
    /// isn't. Any thread.
    double solvingSince_s() const { return _composer.busySince_s(); }
    haptics::ExposureFigures exposure() const { return _ears.reading(); } ///< any thread
    /// As EarWatch::each(); any thread.
    std::vector<haptics::PlaceExposure> ears() const { return _ears.each(); }
    std::vector<std::string> messages() const { return _context.messages.all(); }

private:
    /// How far the messages had come.
    struct Said
    {
        std::uint64_t before = 0; ///< MessageLog::saidNow() as the snapshot came
        std::uint64_t told = 0;   ///< MessageLog::changes() of the last result
    };

    PointAssembler::Options assemblerOptions() const;
    haptics::ComposerOptions lineOptions() const;
    void useOptions(HologramOptions options);
    void useParts(bool otherSolver);
    std::shared_ptr<HologramResult> begin(const SceneSnapshot& snapshot) const;
    std::shared_ptr<const HologramResult> solveAndPlay(const SceneSnapshot& snapshot);
    haptics::ControlPoints assemble(const SceneSnapshot& snapshot, int set, HologramResult& result);
    haptics::FieldSequence compose(const SceneSnapshot& snapshot,
                                   int set,
                                   const haptics::ControlPoints& points,
                                   const haptics::TransducerArray& array);
    void tellReport(const haptics::ControlPoints& points, haptics::FieldSequence& sequence);
    void continueLast(haptics::FieldSequence& sequence) const;
    bool isPlayedAlready(const haptics::FieldSequence& sequence,
                         const haptics::ControlPoints& points) const;
    void offer(const haptics::FieldSequence& whole);
    std::shared_ptr<const HologramResult>
    silent(const SceneSnapshot& snapshot, haptics::StopReason stop, const std::string& why);
    RestStep attendStages();
    std::shared_ptr<HologramResult> playRefined(haptics::FieldSequence sequence);
    std::shared_ptr<HologramResult> lookAfterDevice();
    std::shared_ptr<const HologramResult> finish(std::shared_ptr<HologramResult> made,
                                                 bool isOtherField = true);

    PipelineContext _context;
    EarStage _ears;
    CappedOutput _output;
    PointAssembler _assembler;
    haptics::SequenceComposer _composer;
    HandStage _hands;
    ContactStage _contacts;
    RestRefiner _refiner;
    PlayedFieldMonitor _monitor;
    /// Those above, in the order in which they are asked: at rest contacts come first, and a field
    /// is measured when nothing is left to refine.
    const std::array<PipelineStage*, 5> _stages{&_hands, &_ears, &_contacts, &_refiner, &_monitor};
    bool _isChanged = false;               // the options have changed since the last result
    std::optional<base::Message> _invalid; // what is wrong with the options; none: nothing
    Said _said;
    Eigen::VectorXcf
        _solved; // what the last result was made of, before caps; empty: something else
    UpdateRate _updates;
};

} // namespace midair::bridge
