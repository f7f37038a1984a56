#pragma once

#include "engine-bridge/pipeline/EveningWalk.h"
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

/// Improves the field of a scene at rest: solves outlines as one smooth field; evens a held field
/// of surfaces out, once it has been played for HologramOptions::restAfter_s (EveningWalk), or at
/// once; or solves the other sets of points of a cycle, joins them and evens them out. It works in
/// steps, so that a new snapshot waits for at most one step; those of evening out take about a
/// millisecond. While the array is muted the work waits.
class RestRefiner final : public PipelineStage
{
public:
    /// All arguments must outlive it. \a hands has the hands of the current snapshot.
    RestRefiner(PipelineContext& context,
                PointAssembler& assembler,
                haptics::SequenceComposer& composer,
                HandStage& hands);

    /// Drops all work, and starts again with the first set of points.
    void setOptions() override;
    bool mayPlayOn() const override { return !hasWork() || isHeldYet(); }
    /// Performs the next step. A field that can't be computed is reported, and the playing one
    /// stays. Throws base::Stopped if a stop was requested; the step then has to be repeated.
    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    /// Drops the remaining work.
    void end() override { _isCurrent = false; }
    void report(HologramResult& result, bool isOtherField) override;

    /// Set of points for the next update, 0 .. cycle - 1, in turn. Calls end().
    int nextSet();
    /// To be called before \a made, composed for set \a set of \a snapshot, is played.
    void begin(const SceneSnapshot& snapshot, int set, const haptics::FieldSequence& made);

    /// Snapshot of the last begin(), if there is a monitor or work was left.
    const SceneSnapshot& snapshot() const { return _snapshot; }

private:
    /// Missing parts of the playing field.
    struct Missing
    {
        bool sets = false;
        bool outline = false;
        bool places = false; ///< the playing field or cycle still has to be evened out
    };

    bool hasWork() const;
    // The solver's field is playing, and nothing has been done to even it out.
    bool isHeldYet() const { return _missing.places && _joined.isHeld(); }
    std::optional<haptics::FieldSequence> step();
    std::optional<haptics::FieldSequence> makeOutline();
    haptics::FieldSequence joinSets();
    bool canKeepShare() const;
    void beginToEven();
    void evenAtOnce(const haptics::ControlPoints& places, const haptics::TransducerArray& array);
    bool makeNextSet();
    bool isOutline(const SceneSnapshot& snapshot) const;
    bool isHeldSurface(const SceneSnapshot& snapshot, const haptics::FieldSequence& made) const;
    std::vector<haptics::Outline> outlines(const haptics::ControlPoints& played) const;

    PipelineContext& _context;
    PointAssembler& _assembler;
    haptics::SequenceComposer& _composer;
    HandStage& _hands;

    SceneSnapshot _snapshot;
    bool _isCurrent = false; // _snapshot and the following belong to the playing field
    Missing _missing;
    std::vector<haptics::FieldSequence> _sets; // one per set; isEmpty(): not made yet
    int _next = 0;                             // the set for the next update
    haptics::FieldSequence _joined;            // the field or cycle to be evened out
    double _restsAt_s = 0.0;                   // on the context's clock: no work before
    struct AtOnce
    {
        Eigen::Matrix3Xd points; // of the last field; empty: there was none
        bool isEvened = false;   // it
    };
    AtOnce _before; // if fields are evened out at once
    FeltSurface _surface;
    haptics::EvenedCycle _evened; // a cycle
    EveningWalk _walk;            // a held field
};

} // namespace midair::bridge
