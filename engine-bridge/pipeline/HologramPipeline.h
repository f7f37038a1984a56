#pragma once

#include "engine-bridge/pipeline/CappedOutput.h"
#include "engine-bridge/pipeline/ContactStage.h"
#include "engine-bridge/pipeline/FingertipStage.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/MotionStage.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/PlayedFieldMonitor.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/RestStages.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "haptics/sequence/SequenceComposer.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Processes a snapshot in one thread: assemble (sample, pose and select points) -> compose (solve
/// for the fields) -> cap (limit the pressure at the points) -> play. Hands, ears, contacts,
/// refinement and measurement are stages beside it.
///
/// process() throws for no content of a snapshot: an object that can't be rendered is left out with
/// a message, and if the field can't be computed the array falls silent. Each message is logged
/// once.
class HologramPipeline
{
public:
    /// Throws base::InputError if the options are not valid. A failure to open the device is
    /// reported; fields are then solved and shown, but not played.
    explicit HologramPipeline(HologramOptions options);

    HologramPipeline(const HologramPipeline&) = delete;
    HologramPipeline& operator=(const HologramPipeline&) = delete;

    /// Returns the field for \a snapshot, or the last one again if nothing moved beyond the
    /// tolerance. Never null. \a superseded: number of snapshots dropped in favour of this one, for
    /// the counters only.
    std::shared_ptr<const HologramResult> process(const SceneSnapshot& snapshot,
                                                  std::uint64_t superseded = 0);

    /// To be called while no snapshot comes: resends a field that the device has lost, performs and
    /// plays the next step of a stage at rest, and reports the monitor's result. Returns
    /// null if nothing changed.
    std::shared_ptr<const HologramResult> attend();
    /// Longest time until the next call of attend(), s; 0: work is left.
    double rest_s() const;
    /// Check interval for the device of a still scene: a lost field is resent at most this much
    /// later.
    static constexpr double kAttend_s = 0.5; // a check costs some 50 us, most of it waking up

    /// Silences the array until the next process(), which then solves even if nothing moved.
    void silence() { _output.silence(); }

    /// Uses \a options from the next process() on, which solves even if nothing moved. Array,
    /// device, their factory and the owner stay. The device stays open, the last field stays the
    /// start of the next one if the solver allows it, counters and messages continue. A stricter
    /// cap silences the array until that process(). Invalid options are reported, and nothing is
    /// played until valid ones come.
    void reconfigure(HologramOptions options);

    /// The part of reconfigure() that can't wait: returns true if the caps in \a options are so
    /// strict that the field being played or solved may exceed them. Any thread.
    bool isStricter(const HologramOptions& options) const { return _output.isStricter(options); }
    /// The array. Its functions for any thread may also be called during process(): a field that
    /// process() is working on may still be played after its silenceNow(), unless a stop was
    /// requested before.
    ArrayOutput& device() { return _output.device(); }
    const ArrayOutput& device() const { return _output.device(); }

    /// To be called before the first process(). Once \a stop is requested, process() and attend()
    /// return within milliseconds and send nothing more: process() returns a silent result that
    /// says STOPPED, attend() null.
    void setStop(const base::StopToken& stop);

    /// To be called between calls of process(). Returns true if a device that could not be opened
    /// is open now: process the last snapshot again, which plays it.
    bool isOpenedNow();

    const HologramCounters& counters() const { return _context.counters; }
    const HologramOptions& options() const { return _context.options; }
    /// Start time of the running solve, s on the steady clock; 0: none. Any thread.
    double solvingSince_s() const { return _composer.busySince_s(); }
    haptics::ExposureFigures exposure() const { return _ears.reading(); } ///< any thread
    /// See MotionStage::seen(); any thread.
    std::vector<SeenObject> seen() const { return _motion.seen(); }
    /// See EarWatch::each(); any thread.
    std::vector<haptics::PlaceExposure> ears() const { return _ears.each(); }
    std::vector<std::string> messages() const { return _context.messages.all(); }

private:
    /// Positions in the message log.
    struct Said
    {
        std::uint64_t before = 0; ///< MessageLog::saidNow() when the snapshot came
        std::uint64_t told = 0;   ///< MessageLog::changes() of the last result
    };

    /// The options, since the last result.
    struct Changes
    {
        bool areNew = false;
        std::optional<base::Message> problem; ///< none: they are valid
    };

    PointAssembler::Options assemblerOptions() const;
    haptics::ComposerOptions lineOptions() const;
    void useOptions(HologramOptions options);
    void useParts(bool otherSolver);
    void useReflectors();
    void tellReflectors(const std::string& about, const std::vector<std::string>& problems);
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
    MotionStage _motion;
    EarStage _ears;
    CappedOutput _output;
    PointAssembler _assembler;
    haptics::SequenceComposer _composer;
    HandStage _hands;
    ContactStage _contacts;
    RestStages _rest;
    FingertipStage _fingertip;
    PlayedFieldMonitor _monitor;
    /// The stages above in the order of their calls: at rest contacts come first, and a field is
    /// measured when nothing is left to refine.
    const std::array<PipelineStage*, 9> _stages{&_motion,
                                                &_hands,
                                                &_ears,
                                                &_contacts,
                                                &_rest.refiner,
                                                &_rest.louder,
                                                &_rest.scattering,
                                                &_fingertip,
                                                &_monitor};
    Changes _changes;
    Said _said;
    Eigen::VectorXcf _solved; // input of the last result, before caps; empty: other
};

} // namespace midair::bridge
