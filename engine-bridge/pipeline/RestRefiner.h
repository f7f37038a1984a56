#pragma once

#include "engine-bridge/hands/HandsAndObstacles.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/surface/Outline.h"

#include <optional>
#include <vector>

namespace midair::bridge
{

/// What is still made while nothing moves: outlines in one smooth field, or the fields for the
/// other sets of points of a cycle and then all of them in turn. It works in steps, so that a new
/// snapshot waits for one step at most.
class RestRefiner
{
public:
    /// All references outlive it. \a around holds the hands of the snapshot at hand.
    RestRefiner(const HologramOptions& options,
                PointAssembler& assembler,
                haptics::SequenceComposer& composer,
                ReachAndShadow& around,
                base::MessageLog& messages);

    /// The set of points whose turn it is, 0 .. cycle - 1: of what moves each update takes the
    /// next.
    int nextSet();

    /// \a made was composed for set \a set of \a snapshot and is going to be played.
    void begin(const SceneSnapshot& snapshot, int set, const haptics::FieldSequence& made);
    /// What was begun moved, or is not played.
    void end() { _current = false; }

    /// Whether step() has something to do.
    bool hasWork() const { return _current && (_setsMissing || _outlineMissing); }

    /// The next step. Returns what is to be played from now on, or nothing where more steps follow.
    /// Of what can't be made the reason is a message, and what is played goes on. Throws
    /// base::Stopped where that was asked for: the step is then to do again.
    std::optional<haptics::FieldSequence> step(const haptics::ControlPoints& played,
                                               const haptics::ModulatorOptions& modulation);

    /// The snapshot that begin() was given last, where there is a monitor or something left to do.
    const SceneSnapshot& snapshot() const { return _snapshot; }
    /// How often a solver ran since the last call.
    int takeSolves();

private:
    const haptics::TransducerArray& arrayFor(const haptics::ControlPoints& points);
    bool makeNextSet();
    bool isOutline(const SceneSnapshot& snapshot) const;
    std::vector<haptics::Outline> outlines(const haptics::ControlPoints& played) const;

    const HologramOptions& _options;
    PointAssembler& _assembler;
    haptics::SequenceComposer& _composer;
    ReachAndShadow& _around;
    base::MessageLog& _messages;

    SceneSnapshot _snapshot;
    std::vector<haptics::FieldSequence> _sets; // one a set; no fields: not made yet
    int _next = 0;                             // set for the next update
    int _solves = 0;
    bool _current = false; // snapshot and sets are of what is played
    bool _setsMissing = false;
    bool _outlineMissing = false;
};

} // namespace midair::bridge
