#pragma once

#include "haptics/base/text/MessageLog.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/dense/OutlineHologram.h"

#include <Eigen/Core>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace midair::haptics
{

/// Solves fields in turn, each for a part of the points or an instant of their modulation. They are
/// solved one by one and then scaled to a common level, so that targets are comparable across
/// fields.
class TimeMultiplexer
{
public:
    using Factory = std::function<std::unique_ptr<HologramSolver>()>;

    /// \a makeSolver is called once per field, so that each field can start from its own last one.
    explicit TimeMultiplexer(Factory makeSolver) : _makeSolver(std::move(makeSolver)) {}

    /// Solves one field for each of \a parts (>= 1), in their order, into \a fields (m activations
    /// each, on the array's levels). With relative targets all play at the level of the weakest
    /// field; with absolute targets each at its own. A part without points gives a silent field.
    /// The report covers all fields: rms and max over all points, sums of times and counts,
    /// level_Pa where the target is largest. If a part is REFUSED, so is the report; if a part is
    /// STOPPED, so is the report, with all fields zero. Throws InputError for no parts and for more
    /// than kMostPointsInTurn points.
    SolveReport solve(const std::vector<ControlPoints>& parts,
                      const TransducerArray& array,
                      const Medium& medium,
                      std::vector<Eigen::VectorXcf>& fields);

    /// HologramSolver::achieved_Pa() of the last solve(); empty for several fields.
    Eigen::VectorXf achieved_Pa() const;

    /// HologramSolver::multipliers() and startFrom() of the last solve() if that made one field;
    /// otherwise empty, and false.
    Eigen::VectorXcf multipliers() const;
    bool startFrom(const Eigen::VectorXcf& c);

    /// Replaces the options of all existing solvers; returns false if one of them can't.
    bool setOptions(const SolverOptions& options);

private:
    Factory _makeSolver;
    std::vector<std::unique_ptr<HologramSolver>> _solvers;
    std::vector<SolveReport> _reports;
};

/// Returns the level, Pa per unit of target, of a field with \a report at its \a points; 0 if
/// nothing is played.
double unitLevel(const SolveReport& report, const ControlPoints& points);

/// Returns the common report of fields in turn, from their \a reports (>= 1).
SolveReport together(const std::vector<SolveReport>& reports);

/// SolveReport::solver of composeOutlines().
constexpr const char* kOutlineSolver = "outline";

/// Options of a SequenceComposer.
struct ComposerOptions : SequenceSettings
{
    /// Makes a solver; called for each field that is kept for a warm start. Empty: makeSolver()'s
    /// default with solverOptions.
    std::function<std::unique_ptr<HologramSolver>()> makeSolver;
    /// Options of the solvers. Outlines and an EvenedCycle use their threads, pool, seed, stop
    /// token and loudness.
    SolverOptions solverOptions;
    ModulatorOptions modulation; ///< of all points; rate 0: none; its fieldRate_Hz is not used
    LineRate line;               ///< line to the device; limits field rates and modulations
    bool reorder = true; ///< true: a cycle's fields are sorted so that neighbours differ least
};

/// Modulation of individual points of a set.
struct ModulationPlan
{
    /// >= 0; common to all points, because the array plays one field at a time; 0: not modulated
    double rate_Hz = 0.0;
    /// n, 0 .. 1; the pressure on the skin drops to 1 - depth of its maximum
    Eigen::VectorXd depth;

    bool isModulated() const { return rate_Hz > 0.0; }
    bool isAlike() const { return depth.size() == 0 || depth.minCoeff() == depth.maxCoeff(); }
};

/// Makes FieldSequences from sets of control points: a single field; a field for each subset of the
/// points; one for each instant of a modulation that differs between points; a cycle of fields for
/// shifted sets of points on the same surface; or one stationary field for outlines.
///
/// Each set starts from its last fields. One thread at a time.
class SequenceComposer
{
public:
    /// Maximum number of fields in a period of a modulation; fewer if the field rate requires it.
    static constexpr int kMostInstants = 16;

    SequenceComposer(ComposerOptions options, base::MessageLog& messages);

    /// Returns the sequence for \a points, set number \a set (>= 0) of the scene. If all points
    /// have the same modulation, the whole field is modulated; otherwise there is one field per
    /// instant with the targets of that instant, and no subsets. The options' modulation of all
    /// points overrides \a plan, with a message. If a solver refuses, the report is REFUSED and
    /// there are no fields. Throws base::Stopped if a solver was stopped, base::InputError for no
    /// points and for a modulation too fast for the line. If all sets together have more than
    /// base::kMostPointsInTurn points, some of them start cold.
    FieldSequence compose(int set,
                          const ControlPoints& points,
                          const ModulationPlan& plan,
                          const TransducerArray& array,
                          const Medium& medium);

    /// Returns HologramSolver::multipliers() of the last field of set \a set; empty if it has
    /// several or none.
    Eigen::VectorXcf multipliers(int set) const;
    /// Solves \a held, the last field of set \a set, again, starting from the multipliers \a c.
    /// Returns a sequence without fields if that isn't possible. Throws as compose() does.
    FieldSequence composeFrom(int set,
                              const Eigen::VectorXcf& c,
                              const FieldSequence& held,
                              const TransducerArray& array,
                              const Medium& medium);

    /// Start of the running compose(), s on the steady clock; 0: none is running. Any thread.
    double busySince_s() const { return _busySince_s; }

    /// Returns \a sets (>= 1) as one cycle of fields in turn. If each set has one field, the fields
    /// are sorted so that neighbours differ least, evened out over \a places (see EvenedCycle;
    /// empty: skipped), and joined with the options' steps. Throws base::InputError if a set is
    /// empty or was refused.
    FieldSequence join(std::vector<FieldSequence> sets,
                       const ControlPoints& places,
                       const TransducerArray& array,
                       const Medium& medium);

    /// Calls compose() for each of \a sets, then join().
    FieldSequence composeCycle(const std::vector<ControlPoints>& sets,
                               const ControlPoints& places,
                               const TransducerArray& array,
                               const Medium& medium);

    /// Returns one stationary field for dense points along \a outlines (>= 1, array frame). \a
    /// absolute: targets are in Pa, which the field does not exceed; otherwise the options'
    /// loudness applies (at most 1). Throws as OutlineHologram::solve() does.
    FieldSequence composeOutlines(const std::vector<Outline>& outlines,
                                  bool absolute,
                                  const ModulatorOptions& modulation,
                                  const TransducerArray& array,
                                  const Medium& medium);

    /// Replaces the options between two compositions. Each set still starts from its last fields,
    /// unless \a otherSolver, or if a solver can't change its options.
    void setOptions(ComposerOptions options, bool otherSolver);

    /// Sets the token; call it before the first solve. If \a stop requests it, a running
    /// composition throws base::Stopped.
    void setStop(const base::StopToken& stop) { _options.solverOptions.stop = stop; }
    const ComposerOptions& options() const { return _options; }

private:
    /// Solvers and fields of one set of points.
    struct Kept
    {
        TimeMultiplexer solvers;
        std::vector<Eigen::VectorXcf> fields; // last fields
        int points = 0;                       // number of points in their matrices
    };

    Kept& keptFor(int set, int points);
    static void
    solve(Kept& kept, const TransducerArray& array, const Medium& medium, FieldSequence& sequence);
    std::vector<ControlPoints>
    split(const ControlPoints& points, const ModulationPlan& plan, FieldSequence& sequence);

    ComposerOptions _options;
    base::MessageLog& _messages;
    std::map<int, Kept> _kept;
    std::unique_ptr<OutlineHologram> _outlines; // made with the first outline
    std::atomic<double> _busySince_s{0.0};
};

} // namespace midair::haptics
