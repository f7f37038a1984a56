#pragma once

#include "engine-bridge/hands/HandsAndObstacles.h"
#include "engine-bridge/pipeline/FeltSurface.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/EvenedCycle.h"
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
class RestRefiner
{
public:
    /// All references must outlive it. \a around holds the hands of the current snapshot.
    RestRefiner(const HologramOptions& options,
                PointAssembler& assembler,
                haptics::SequenceComposer& composer,
                ReachAndShadow& around,
                base::MessageLog& messages);

    /// The set of points for the next update, 0 .. cycle - 1, each in turn. Calls end().
    int nextSet();

    /// To be called when \a made, composed for set \a set of \a snapshot, is going to be played.
    void begin(const SceneSnapshot& snapshot, int set, const haptics::FieldSequence& made);
    /// To be called when the scene moved or is not played: drops the work that is left.
    void end() { _current = false; }

    /// Returns true if step() has something to do.
    bool hasWork() const
    {
        return _current && (_setsMissing || _outlineMissing || _placesMissing || _evened.hasWork());
    }

    /// Does the next step. Returns what is to be played from now on, or nothing if what is played
    /// stays. If a field can't be made, the reason is a message and what is played stays. Throws
    /// base::Stopped if a stop was requested; the step is then to be done again. \a played are the
    /// points that are played, \a modulation goes into an outline's field.
    std::optional<haptics::FieldSequence> step(const haptics::ControlPoints& played,
                                               const haptics::ModulatorOptions& modulation);

    /// The snapshot that begin() was given last, if there is a monitor or something was left to do.
    const SceneSnapshot& snapshot() const { return _snapshot; }
    /// The number of solves since the last call.
    int takeSolves();

    /// To be called before the first step().
    void setStop(const base::StopToken& stop);

private:
    std::optional<haptics::FieldSequence> makeOutline(const haptics::ControlPoints& played,
                                                      const haptics::ModulatorOptions& modulation);
    haptics::FieldSequence joinSets();
    void beginToEven(const haptics::ControlPoints& played);
    bool makeNextSet();
    bool isOutline(const SceneSnapshot& snapshot) const;
    std::vector<haptics::Outline> outlines(const haptics::ControlPoints& played) const;

    const HologramOptions& _options;
    PointAssembler& _assembler;
    haptics::SequenceComposer& _composer;
    ReachAndShadow& _around;
    base::MessageLog& _messages;

    SceneSnapshot _snapshot;
    std::vector<haptics::FieldSequence> _sets; // one per set; isEmpty(): not made yet
    int _next = 0;                             // the set for the next update
    int _solves = 0;
    bool _current = false; // _snapshot and _sets belong to what is played
    bool _setsMissing = false;
    bool _outlineMissing = false;
    bool _placesMissing = false;    // the cycle that is played is to be evened out
    haptics::FieldSequence _joined; // that cycle
    FeltSurface _surface;
    haptics::EvenedCycle _evened;
};

} // namespace midair::bridge
