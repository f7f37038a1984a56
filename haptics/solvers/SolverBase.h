#pragma once

#include "haptics/base/Limits.h"
#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Returns true for a tolerance so coarse that single precision of distances, an error of up to
/// 8e-4 in an entry of G, and a level off by the tolerance are good enough (SOLVER.md, "Coarse
/// tolerances").
constexpr bool isCoarseTolerance(double rmsTolerance)
{
    return rmsTolerance >= 3e-3;
}

/// Base of all methods: checks the input, skips a solve if nothing has moved, builds the matrix,
/// provides a warm start, rounds the activations to the device's levels and makes the report. A
/// method finds the phases (and amplitudes).
class SolverBase : public HologramSolver
{
public:
    SolverBase(std::string name, const SolverOptions& options, Storage storage = Storage::FLOAT);

    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) final;
    /// Returns the given options with loudness limited to 1; this class handles more.
    const SolverOptions& options() const final { return _options; }
    const TransducerArray* ownArray() const final { return &_field.G.array(); }
    /// Accepts any options with its own pool, or without one.
    bool setOptions(const SolverOptions& options) final;
    const Eigen::VectorXf& achieved_Pa() const final { return _last.achieved_Pa; }
    Eigen::VectorXcf multipliers() const final;
    bool startFrom(const Eigen::VectorXcf& c) final;

protected:
    struct Outcome
    {
        int iterations = 0;
        StopReason stop = StopReason::MAX_ITERATIONS;
        bool unfinished = false; ///< solving again for the same points improves it
        bool playable = false;   ///< field.q is already on the device's levels
        bool measured = false;   ///< field.y belongs to field.q as the device plays it
    };

    /// Finds q for the targets field.a, starting from field.u; \a warm: the points correspond to
    /// the last field's. Leaves the result in field.q: with phaseOnly only its phases count;
    /// otherwise rms |q| = 1 means full use of the array, and amplitudes above 1 are clipped.
    virtual Outcome iterate(FieldProblem& field, bool warm) = 0;

    /// Called instead of field.build() if the points correspond to the last field's, so that a
    /// method can combine the build with its first round. iterate() follows; if points were out of
    /// reach, field.build() is called for the others first.
    virtual void build(FieldProblem& field) { field.build(); }

    /// Called before a warm iterate() if points have come or gone: point l is the last field's
    /// point \a lastOf[l], or new (-1). A method that keeps data per point reassigns it and returns
    /// true; by default it returns false and starts from the phases of the last field at the
    /// points.
    virtual bool carryOver(const FieldProblem& /*field*/, const std::vector<int>& /*lastOf*/)
    {
        return false;
    }

    /// multipliers() of the field's points; empty: the last field has none.
    virtual Eigen::VectorXcf multipliersOf(const FieldProblem& /*field*/) const { return {}; }
    /// startFrom() for the field's points; false: not possible.
    virtual bool take(FieldProblem& /*field*/, const Eigen::VectorXcf& /*c*/) { return false; }

    /// Returns true if the options' deadline has passed; methods call it in every iteration. Throws
    /// Stopped on a stop request.
    bool outOfTime(const FieldProblem& field) const
    {
        _options.stop.throwIfRequested();
        return _options.deadline_ms > 0.0 && field.elapsed_ms() >= _options.deadline_ms;
    }
    /// Returns the options' limit of iterations, or \a methodsOwn if there is none.
    int iterationLimit(int methodsOwn) const
    {
        return _options.maxIterations > 0 ? _options.maxIterations : methodsOwn;
    }

    /// Returns the maximum number of control points for the method's time and memory; more are
    /// REFUSED.
    virtual int mostPoints() const { return base::kMostControlPoints; }

    /// Turns field.q and field.u by the common phase that brings q nearest to the last field.
    /// Returns the factor, of modulus 1. \a levels over 0: q is on that many phase levels and stays
    /// on them.
    std::complex<float> alignToLast(FieldProblem& field, int levels = 0);
    bool hasLast(const FieldProblem& field) const { return _last.q.size() == field.arraySize(); }
    /// Returns true if the targets of this solve are in Pa.
    bool isAbsolute() const { return _targets.isAbsolute; }
    /// Returns true if the targets of this solve are shifted for loudness, towards the pressures
    /// that the points have anyway.
    bool isShifted() const { return _loudness.now > 0.0; }
    /// Returns the largest target, the divisor of all targets; in FieldProblem::unit_Pa() if the
    /// targets are in Pa.
    float largestTarget() const { return static_cast<float>(_targets.largest / _field.unit_Pa()); }

private:
    /// Result of the last solve, kept for the next one; good is false before the first field and
    /// after a solve without one.
    struct LastField
    {
        bool good = false;
        bool goesOn = false;                 // to be solved again: unfinished and improved by the
                                             // last solve, or given another start
        std::vector<int> active;             // indices of its points
        std::vector<std::uint64_t> identity; // of these, or empty
        Eigen::VectorXd targets;             // their targets, as given
        Eigen::VectorXcf q; // m, as played by the device, in the array's order; empty: none yet
        SplitVector lanes;  // the same in the matrix's order, padded with zeros
        SplitVector u;      // phases at the points
        SolveReport report;
        Eigen::VectorXf achieved_Pa; // at all points of this solve; empty: not accurately known
    };

    /// Loudness above 1: share of the way to the loudest field.
    struct Loudness
    {
        double wanted = 0.0; // 0 .. 1
        double now = 0.0;    // in this solve; 0 if the targets are in Pa
        SplitVector u;       // n, phases at the start of the way
        Eigen::VectorXf a;   // n, targets as given
    };
    /// The targets of this solve.
    struct Targets
    {
        bool isAbsolute = false; // in Pa
        float largest = 1.0f;    // divisor of the targets, as given
        int raised = 0;          // number of targets raised to the minimum
        float quieter = 0.0f;    // level of a quieter field that is farther from targets in Pa
        bool isGrown = false;    // the field comes from growFromBelow()
    };
    /// The points of this solve.
    struct Points
    {
        std::vector<int> active;             // their indices
        std::vector<std::uint64_t> identity; // of these, or empty
        std::vector<int> lastOf;             // index of each in the last field; -1: new
    };

    SolveReport solveUnlessStopped(const ControlPoints& points,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   Eigen::VectorXcf& q);
    SolveReport solveAssigned(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              int stale,
                              SolveReport& result,
                              Eigen::VectorXcf& q);
    double skipTolerance_m(const TransducerArray& array, const Medium& medium) const;
    std::string tooQuiet() const;
    std::string tooLarge(int points, int transducers) const;
    std::string refusal(const ControlPoints& points,
                        const TransducerArray& array,
                        const Medium& medium,
                        const Eigen::VectorXcf& q,
                        bool isKnown) const;
    void chooseActive(const ControlPoints& points);
    bool areLastPoints() const;
    bool findLastPoints();
    bool goOn();
    bool dropUnreachable();
    bool isSkippable(int stale, const Eigen::VectorXcf& q) const;
    bool isContinued(const TransducerArray& array) const;
    bool prepareStart(const TransducerArray& array);
    Outcome iterateLouder(bool warm);
    void scaleTargets();
    void makePlayable();
    void playTargets();
    void keepToTargets(Outcome& outcome);
    void measure(const Outcome& outcome,
                 const ControlPoints& points,
                 const TransducerArray& array,
                 const Medium& medium);
    void report(const Outcome& outcome, SolveReport& report);
    void reportTargets(SolveReport& report) const;
    void reportChange(SolveReport& report) const;
    void tellDeadline(SolveReport& report);
    void keep(const SolveReport& report, Eigen::VectorXcf& q);
    void keepAchieved(const SolveReport& report);
    SolveReport
    silent(SolveReport report, StopReason stop, std::string why, int m, Eigen::VectorXcf& q);

    void take(const SolverOptions& options);

    std::string _name;
    SolverOptions _options;
    Loudness _loudness;
    double _audibleShare = 0.0; // audible share of a drive's change at the options' update rate
    FieldProblem _field;
    Targets _targets;
    Points _points;
    int _misses = 0; // consecutive solves that exceeded the deadline
    LastField _last;
};

} // namespace midair::haptics
