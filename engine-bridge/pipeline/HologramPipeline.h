#pragma once

#include "engine-bridge/hands/HandsAndObstacles.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/PlayedFieldMonitor.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"

#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The way of one snapshot to the array, in one thread: assemble (samples, posed and selected) ->
/// compose (what is to be played) -> cap (no point gets more than it may) -> play.
///
/// Nothing that a snapshot holds makes process() throw: an object that can't be felt is left out
/// with a message, and when the field can't be made the array falls silent. The message log says
/// each thing once.
class HologramPipeline
{
public:
    /// Throws base::InputError where the options are wrong. A device that can't be opened is a
    /// message: the field is then solved and shown as it would be played.
    explicit HologramPipeline(HologramOptions options);

    HologramPipeline(const HologramPipeline&) = delete;
    HologramPipeline& operator=(const HologramPipeline&) = delete;

    /// The field for \a snapshot, or the last one again where nothing moved by more than the
    /// tolerance. Never null. \a superseded: how many snapshots were dropped for this one; only
    /// counted.
    std::shared_ptr<const HologramResult> process(const SceneSnapshot& snapshot,
                                                  std::uint64_t superseded = 0);

    /// To be called now and then while no snapshot comes: sends the field again that a device has
    /// lost, since what doesn't move brings no next field; makes and plays what is still missing
    /// for what rests; hands on what the monitor found. Null where nothing changed.
    std::shared_ptr<const HologramResult> attend();
    /// How long attend() may be put off, s.
    double rest_s() const;
    /// A device that plays a still scene is looked after so often: a field that it lost is back
    /// within a blink.
    static constexpr double kAttend_s = 0.5; // each look costs some 50 us, most of it waking up

    /// The array plays nothing until the next process(), which solves in any case.
    void silence() { _output->silence(ArrayOutput::Silence::FAILED); }

    /// To be given before the first process(). Where \a stop asks for it process() and attend() are
    /// back within milliseconds, with nothing sent any more: process() STOPPED and silent, attend()
    /// as if nothing had changed.
    void setStop(const base::StopToken& stop);
    /// Any thread, while process() is at work: the array is silent. What is in hand may be played
    /// after it, unless a stop was asked for before.
    void silenceNow() { _output->silenceNow(); }

    const HologramCounters& counters() const { return _counters; }
    const HologramOptions& options() const { return _options; }
    const std::vector<std::string>& messages() const { return _messages.all(); }

private:
    void openOutput();
    std::shared_ptr<const HologramResult> solveAndPlay(const SceneSnapshot& snapshot);
    std::shared_ptr<const HologramResult>
    silent(const SceneSnapshot& snapshot, haptics::StopReason stop, const std::string& why);
    std::shared_ptr<const HologramResult> lookAfterDevice();
    std::shared_ptr<const HologramResult> refine();
    std::shared_ptr<const HologramResult> askMonitor();

    haptics::ControlPoints assemble(const SceneSnapshot& snapshot, int set, HologramResult& result);
    const haptics::TransducerArray& arrayFor(const haptics::ControlPoints& points);
    void continueLast(haptics::FieldSequence& sequence) const;
    void cap(const haptics::TransducerArray& array,
             haptics::FieldSequence& sequence,
             HologramResult& result);
    void play(const haptics::TransducerArray& array,
              haptics::FieldSequence sequence,
              HologramResult& result);
    void measure(const haptics::TransducerArray& array, HologramResult& result) const;
    void finish(HologramResult& result);

    HologramOptions _options;
    base::MessageLog _messages;
    std::unique_ptr<ArrayOutput> _output;
    std::unique_ptr<PressureCap> _cap; // null: there is none
    haptics::LineRate _line;
    std::unique_ptr<PointAssembler> _assembler;
    std::unique_ptr<haptics::SequenceComposer> _composer;
    std::unique_ptr<RestRefiner> _refiner;
    std::unique_ptr<PlayedFieldMonitor> _monitor;
    ReachAndShadow _around;
    HologramCounters _counters;
    std::shared_ptr<const HologramResult> _last;
    UpdateRate _updates;
};

} // namespace midair::bridge
