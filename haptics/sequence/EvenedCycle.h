#pragma once

#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/sequence/FieldSequence.h"

#include <optional>

namespace midair::haptics
{

/// Evens a cycle out in slices and hands out each cycle on the way that is worth playing. Its
/// fields keep their order and their phases, so that one cycle can replace the other while it
/// plays.
class EvenedCycle
{
public:
    /// \a passes: >= 0, as CycleEqualizerOptions::passes. \a steps: >= 0, intermediate fields after
    /// each field of the cycle. Takes threads, pool and stop token from \a solver.
    EvenedCycle(int passes, int steps, const SolverOptions& solver);

    /// Starts with \a cycle: one field for each of its parts, with the steps between them, as
    /// SequenceComposer::join() makes it. Returns false, with nothing to do, as
    /// CycleEqualizer::begin() does, without passes, and for targets in Pa: points then are to have
    /// their pressure in the field that is for them.
    bool begin(const FieldSequence& cycle,
               const ControlPoints& places,
               const TransducerArray& array,
               const Medium& medium);
    /// Does the next slice. Returns a cycle once it is more even than the last one by kWorthIt, or
    /// the last one of all; it is `evened`, and its report has the figures of the steps between its
    /// fields, but not yet those of what is felt. A cycle weaker than the given one by over
    /// 1 - kLeastGain is not handed out. Throws base::Stopped, to be called again.
    std::optional<FieldSequence> step();
    bool hasWork() const { return _equalizer.hasWork(); }
    void end() { _equalizer.end(); } ///< drops the work that is left
    const CycleEqualizer& equalizer() const { return _equalizer; }

    static constexpr double kWorthIt = 0.7;    ///< factor on the coefficient of variation
    static constexpr double kLeastGain = 0.98; ///< of the mean radiation pressure

private:
    FieldSequence made() const;

    CycleEqualizer _equalizer;
    int _passes;
    int _steps;
    FieldSequence _cycle; // as given
    DriveResolution _drive;
    double _ringing_s = 0.0;
    double _handedOut = 0.0; // variation of the last cycle that was, at first of the given one
    int _seen = 0;           // passes of the equaliser that were looked at
};

} // namespace midair::haptics
