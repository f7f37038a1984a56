#pragma once

#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/sequence/LineRate.h"
#include "haptics/sequence/TimeMultiplexer.h"
#include "haptics/solvers/dense/OutlineHologram.h"

#include <Eigen/Core>

#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace midair::haptics
{

/// How sets of control points become what is played.
struct ComposerOptions
{
    /// Makes one solver for each field that is kept warm; empty: makeSolver's default with
    /// solverOptions.
    std::function<std::unique_ptr<HologramSolver>()> makeSolver;
    /// Of the solvers; outlines and evening take threads, pool, seed, stop token and loudness from
    /// them.
    SolverOptions solverOptions;
    /// Amplitude modulation of everything (rate 0: none), and how many fields a second follow each
    /// other.
    ModulatorOptions modulation;
    LineRate line;       ///< to the device; what it doesn't carry is not composed
    int subsets = 1;     ///< 1 .. 64; of the points of a set, played in turn
    int cycleSteps = 0;  ///< >= 0; fields between one of a cycle and the next
    bool reorder = true; ///< a cycle's fields are played in the order in which they differ least
    int sweeps = 0; ///< >= 0; in which a cycle's fields are evened out together: CycleEqualizer
    int sweepCorrections = 2; ///< >= 1; for each field and sweep
};

/// How the points of a set are to be modulated by themselves.
struct ModulationPlan
{
    /// >= 0; one for all, since the array plays one field at a time; 0: not modulated
    double rate_Hz = 0.0;
    Eigen::VectorXd depth; ///< n, 0 .. 1; by how much of itself the pressure on the skin goes down

    bool isModulated() const { return rate_Hz > 0.0; }
    bool isAlike() const { return depth.size() == 0 || depth.minCoeff() == depth.maxCoeff(); }
};

/// The only way from sets of control points to a FieldSequence: one field; a field for each subset
/// of the points; one for each instant of a modulation in which the points take part differently; a
/// cycle of fields for shifted sets of points on the same surface; or an outline in one stationary
/// field.
///
/// Each set starts warm from its own last fields. One thread at a time.
class SequenceComposer
{
public:
    /// A period of a modulation is played in as many fields as the field rate allows, kMostInstants
    /// at most.
    static constexpr int kMostInstants = 16;

    SequenceComposer(ComposerOptions options, base::MessageLog& messages);

    /// What is played for \a points, which are set number \a set (>= 0) of the scene. Points that
    /// are modulated alike are modulated as a whole; else there is one field an instant, each with
    /// the targets of its instant, and subsets are not made. A modulation of everything (the
    /// options') goes before \a plan, with a message. The report says REFUSED, and there are no
    /// fields, where a solver refuses. Throws base::Stopped where a solver was stopped,
    /// base::InputError for a modulation that the line doesn't carry and for no points. Sets of
    /// more than base::kMostPointsInTurn points together start cold, some of them.
    FieldSequence compose(int set,
                          const ControlPoints& points,
                          const ModulationPlan& plan,
                          const TransducerArray& array,
                          const Medium& medium);

    /// \a sets (>= 1) in turn, as one cycle. Where each has one field they are evened out over \a
    /// surface (3 x n, dense; none: not), put into the order in which they differ least, and get
    /// the options' steps between them. Throws base::InputError where a set is empty or was
    /// refused.
    FieldSequence join(std::vector<FieldSequence> sets,
                       const Eigen::Matrix3Xd& surface,
                       const TransducerArray& array,
                       const Medium& medium);

    /// Calls compose() for each of \a sets, then join().
    FieldSequence composeCycle(const std::vector<ControlPoints>& sets,
                               const Eigen::Matrix3Xd& surface,
                               const TransducerArray& array,
                               const Medium& medium);

    /// \a outlines (>= 1, array frame) in one stationary field for dense points along them. \a
    /// absolute: their targets are in Pa, and the field is no louder than that; it is as loud as
    /// the options' loudness (1 at most) says else. Throws as OutlineHologram::solve does.
    FieldSequence composeOutlines(const std::vector<Outline>& outlines,
                                  bool absolute,
                                  const ModulatorOptions& modulation,
                                  const TransducerArray& array,
                                  const Medium& medium);

    /// Sets the token; call it before the first solve. Where \a stop asks for it, what is being
    /// composed throws base::Stopped.
    void setStop(const base::StopToken& stop) { _options.solverOptions.stop = stop; }
    const ComposerOptions& options() const { return _options; }

private:
    /// What is kept for one set of points.
    struct Kept
    {
        TimeMultiplexer solvers;
        std::vector<Eigen::VectorXcf> fields; // what they left
        int points = 0;                       // of all fields that these keep matrices for
    };

    Kept& keptFor(int set, int points);
    std::vector<ControlPoints>
    split(const ControlPoints& points, const ModulationPlan& plan, FieldSequence& sequence);

    ComposerOptions _options;
    base::MessageLog& _messages;
    std::map<int, Kept> _kept;
    std::unique_ptr<OutlineHologram> _outlines; // from the first outline on
};

} // namespace midair::haptics
