#pragma once

#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/SampleCache.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/surface/Outline.h"

#include <optional>
#include <vector>

namespace midair::bridge
{

/// Improves the field of a scene at rest: solves outlines as one smooth field, or solves for the
/// other sets of points of a cycle, joins all of them and evens them out. It works in steps, so
/// that a new snapshot waits for one step at most; those of the evening out take a millisecond or
/// so.
class RestRefiner final : public PipelineStage
{
public:
    /// All must outlive it. \a hands has the hands of the current snapshot.
    RestRefiner(PipelineContext& context,
                PointAssembler& assembler,
                haptics::SequenceComposer& composer,
                HandStage& hands);

    /// Drops all work, and begins with the first set of points again.
    void setOptions() override;
    bool mayPlayOn() const override { return !hasWork(); }
    void settle(const HologramResult& result,
                const SceneSnapshot& snapshot,
                const haptics::TransducerArray& array) override;
    /// Makes the next step. If a field can't be made, the reason is a message and what is played
    /// stays. Throws base::Stopped if a stop was requested; the step is then to be done again.
    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    /// Drops the work that is left.
    void end() override { _isCurrent = false; }

    /// The set of points for the next update, 0 .. cycle - 1, each in turn. Calls end().
    int nextSet();
    /// To be called when \a made, composed for set \a set of \a snapshot, is going to be played.
    void begin(const SceneSnapshot& snapshot, int set, const haptics::FieldSequence& made);

    /// The snapshot that begin() was given last, if there is a monitor or something was left to do.
    const SceneSnapshot& snapshot() const { return _snapshot; }

private:
    /// What of the field that is played is still to be made.
    struct Missing
    {
        bool sets = false;
        bool outline = false;
        bool places = false; ///< the cycle that is played is to be evened out
    };

    bool hasWork() const;
    std::optional<haptics::FieldSequence> step();
    std::optional<haptics::FieldSequence> makeOutline();
    haptics::FieldSequence joinSets();
    void beginToEven();
    bool makeNextSet();
    bool isOutline(const SceneSnapshot& snapshot) const;
    std::vector<haptics::Outline> outlines(const haptics::ControlPoints& played) const;

    PipelineContext& _context;
    PointAssembler& _assembler;
    haptics::SequenceComposer& _composer;
    HandStage& _hands;

    SceneSnapshot _snapshot;
    bool _isCurrent = false; // _snapshot and what follows belong to what is played
    Missing _missing;
    std::vector<haptics::FieldSequence> _sets; // one per set; isEmpty(): not made yet
    int _next = 0;                             // the set for the next update
    haptics::FieldSequence _joined;            // the cycle that is to be evened out
    FeltSurface _surface;
    haptics::EvenedCycle _evened;
};

} // namespace midair::bridge
