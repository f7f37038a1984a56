#pragma once

#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/SampleCache.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/production/LouderPhases.h"

#include <Eigen/Core>

#include <deque>
#include <optional>

namespace midair::bridge
{

/// Time from one field of a walk at rest to the next, s.
constexpr double kWalkPace_s = 0.005;

/// Turns \a next, a held field on \a walk, to be near the context's last one, and rates the step.
/// Returns true if it keeps the bounds of the walk: it is then to be played.
bool keepsBounds(PipelineContext& context, haptics::PhaseWalk& walk, haptics::FieldSequence& next);

/// Leads a held field that plays to an evened one in steps too small to be felt. The way there is
/// that of the equalizer: its passes, one after the other, none of which turns the phases far. So
/// fields on the way are nearly as strong, which fields between two unrelated ones are not. They
/// are walked once the equalizer is at a field worth playing (haptics::EvenedCycle).
class EveningWalk
{
public:
    explicit EveningWalk(PipelineContext& context);

    /// The context's options have changed: ends.
    void setOptions();
    /// Starts with \a held, which the last result plays, at \a where. No field on the way is played
    /// at a larger share of its drive than caps leave of that one.
    void begin(const haptics::FieldSequence& held,
               PlacesToEven where,
               const haptics::TransducerArray& array);
    bool hasWork() const { return _evened.hasWork() || isWalking(); }
    /// Time until step() has work, s; 0 without any.
    double rest_s() const;
    /// Does a slice of the equalizer's work, or returns the next field. Throws base::Stopped; it
    /// may then be called again. \a array: that of the playing field.
    std::optional<haptics::FieldSequence> step(const haptics::TransducerArray& array);
    void end();

    /// Measures the field of \a result, as played, if the last measurement is old, and stores the
    /// figures of the field measured last in its report.
    void report(HologramResult& result, bool isOtherField);

private:
    /// A field that the equalizer found.
    struct Stop
    {
        Eigen::VectorXcf field; ///< m; not rounded, or many phases would change their level at once
        double gain = 1.0;      ///< CycleEqualizer::gain()
    };
    /// Fields as the equalizer finds them.
    struct Trail
    {
        std::deque<Stop> stops; ///< not walked yet
        std::size_t open = 0;   ///< number of the first of them that may be walked
        int seen = 0;           ///< passes of the equalizer
    };
    struct Measured
    {
        Eigen::Matrix3Xd places; ///< 3 x k, between those that are evened out
        haptics::SurfaceStatistics surface;
        double next_s = 0.0; ///< on the context's clock; no measurement before
    };

    bool isWalking() const { return _trail.open > 0 || !_walk.isOver(); }
    void look();
    void aim();
    std::optional<haptics::FieldSequence> walk(const haptics::TransducerArray& array);

    PipelineContext& _context;
    haptics::EvenedCycle _evened;
    haptics::FieldSequence _held; // as given
    Trail _trail;
    haptics::PhaseWalk _walk;
    Stop _at;            // where the walk ends or ended
    double _due_s = 0.0; // on the context's clock: no field before
    Measured _measured;
};

} // namespace midair::bridge
