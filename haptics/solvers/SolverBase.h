#pragma once

#include "haptics/base/Limits.h"
#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// What all methods share: it checks the input, skips what has not moved, builds the matrix, starts
/// warm, brings the activations onto the device's levels and makes the report. A method finds the
/// phases (and amplitudes).
class SolverBase : public HologramSolver
{
public:
    SolverBase(std::string name, const SolverOptions& options, Storage storage = Storage::FLOAT);

    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) final;
    /// As they were given, but for the loudness, which is 1 at most: what is asked for beyond 1 is
    /// done here.
    const SolverOptions& options() const final { return _options; }

protected:
    struct Outcome
    {
        int iterations = 0;
        StopReason stop = StopReason::MAX_ITERATIONS;
        bool playable = false; ///< field.q is on the device's levels already
        bool measured = false; ///< field.y is that of field.q as the device plays it
    };

    /// Finds q for field.a, starting from field.u when \a warm (else u is 1). Leaves it in field.q:
    /// with phaseOnly only its phases count; else rms |q| = 1 is taken as full use of the array,
    /// and what is over 1 is clipped.
    virtual Outcome iterate(FieldProblem& field, bool warm) = 0;

    /// Called in place of field.build() where the points correspond to the last field's: a method
    /// may build and take its first round in one. iterate follows, unless points are out of reach.
    virtual void build(FieldProblem& field) { field.build(); }

    /// True once the options' deadline has passed; a method asks in every turn of its loops. Throws
    /// Stopped where the options' token asks for it.
    bool outOfTime(const FieldProblem& field) const
    {
        _options.stop.throwIfRequested();
        return _options.deadline_ms > 0.0 && field.elapsed_ms() >= _options.deadline_ms;
    }
    int iterationLimit(int methodsOwn) const
    {
        return _options.maxIterations > 0 ? _options.maxIterations : methodsOwn;
    }

    /// How many control points the method has time and memory for; more are REFUSED.
    virtual int mostPoints() const { return base::kMostControlPoints; }

    /// Turns field.q and field.u by the common phase that brings q nearest to the last field, and
    /// returns it.
    std::complex<float> alignToLast(FieldProblem& field);
    bool hasLast(const FieldProblem& field) const { return _last.q.size() == field.m(); }
    /// Moves field.q towards the last field until no transducer's phase or amplitude differs from
    /// it by more than the options allow.
    void limitSteps();
    bool isLimited() const
    {
        return _options.maxPhaseStep_rad > 0.0 || _options.maxAmplitudeStep > 0.0;
    }
    /// Whether the targets at hand are in Pa.
    bool isAbsolute() const { return _absolute; }
    /// The largest target, by which the targets were divided so that the largest is 1; in Pa where
    /// the targets are.
    float largestTarget() const { return _largestTarget; }

private:
    /// What the last solve left for the next one; good is false before the first field and after a
    /// refusal.
    struct LastField
    {
        bool good = false;
        std::vector<int> active; // the points that it was solved for
        Eigen::VectorXd targets; // theirs, as they were asked for
        Eigen::VectorXcf q; // m, as the device played it, in the array's order; empty: none yet
        SplitVector lanes;  // the same in the matrix's order, padded with zeros
        SolveReport report;
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
    std::string tooLarge(int points, int transducers) const;
    std::string refusal(const ControlPoints& points,
                        const TransducerArray& array,
                        const Medium& medium,
                        bool isKnown) const;
    void chooseActive(const ControlPoints& points);
    bool dropUnreachable();
    bool isSkippable(int stale, const Eigen::VectorXcf& q) const;
    bool isContinued(const TransducerArray& array) const;
    bool prepareStart(const TransducerArray& array);
    Outcome iterateLouder(bool warm);
    void scaleTargets();
    void makePlayable();
    void report(const Outcome& outcome, SolveReport& report);
    void reportShortfall(SolveReport& report) const;
    void keep(const SolveReport& report, Eigen::VectorXcf& q);
    SolveReport
    silent(SolveReport report, StopReason stop, std::string why, int m, Eigen::VectorXcf& q);

    std::string _name;
    SolverOptions _options;
    double _louder = 0.0;   // 0 .. 1: the share of the way to the loudest field that is asked for
    double _beyond = 0.0;   // the same for the targets at hand: 0 for those in Pa
    bool _absolute = false; // the targets at hand are in Pa
    double _audibleShare = 0.0; // of the drive's change, at the options' rate
    SplitVector _keptU;         // n
    Eigen::VectorXf _keptA;     // n
    FieldProblem _field;
    std::vector<int> _active;    // the points that are solved for
    float _largestTarget = 1.0f; // what the targets were divided by
    LastField _last;
};

} // namespace midair::haptics
