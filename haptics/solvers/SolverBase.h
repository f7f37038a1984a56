#pragma once

#include "haptics/base/Limits.h"
#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// What every method shares: checking input, skipping, the matrix, warm starts, what the device can play, the report.
/// A method says how phases (and amplitudes) are found.
class SolverBase : public HologramSolver
{
public:
    SolverBase(std::string name, const SolverOptions& options, Storage storage = Storage::FLOAT);

    SolveReport solve(const ControlPoints& points,
                      const TransducerArray& array,
                      const Medium& medium,
                      Eigen::VectorXcf& q) final;
    /// With a loudness of 1 at most: what is asked for beyond is done here, with relative targets.
    const SolverOptions& options() const final { return _options; }

protected:
    struct Outcome
    {
        int iterations = 0;
        StopReason stop = StopReason::MAX_ITERATIONS;
        bool playable = false; ///< q stands on the device's levels already
        bool measured = false; ///< and field.y belongs to it
    };

    /// Finds q for field.a, starting from field.u when \a warm (else u is 1). Leaves it in field.q: with phaseOnly only its
    /// phases count; else rms |q| = 1 is taken as full use of the array, and what is over 1 is clipped.
    virtual Outcome iterate(FieldProblem& field, bool warm) = 0;

    /// Called in place of field.build() where the points correspond to the last field's: a method may build and take its
    /// first round in one. iterate follows, unless points are out of reach.
    virtual void build(FieldProblem& field) { field.build(); }

    /// To be asked in every turn of a loop. Throws Stopped where that was asked for.
    bool outOfTime(const FieldProblem& field) const
    {
        _options.stop.throwIfRequested();
        return _options.deadline_ms > 0.0 && field.elapsed_ms() >= _options.deadline_ms;
    }
    int iterationLimit(int methodsOwn) const
    {
        return _options.maxIterations > 0 ? _options.maxIterations : methodsOwn;
    }

    /// Control points that the method has time and memory for.
    virtual int mostPoints() const { return base::kMostControlPoints; }

    /// Turns field.q and field.u by the common phase that brings q nearest to the last field, and returns it.
    std::complex<float> alignToLast(FieldProblem& field);
    bool hasLast(const FieldProblem& field) const { return _lastQ.size() == field.m(); }
    /// Holds field.q within the options' steps from the last field.
    void limitSteps();
    bool isLimited() const
    {
        return _options.maxPhaseStep_rad > 0.0 || _options.maxAmplitudeStep > 0.0;
    }
    /// Whether the targets at hand are in Pa.
    bool isAbsolute() const { return _absolute; }
    /// What targets were divided by so that the largest is 1: Pa with absolute targets.
    float largestTarget() const { return _largestTarget; }

private:
    struct Level
    {
        double s = 0.0, rms = 0.0, max = 0.0;
    };

    SolveReport solveUnlessStopped(const ControlPoints& points,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   Eigen::VectorXcf& q);
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
    void makePlayable(const Outcome& outcome);
    Level measure(bool absolute) const;
    void report(const Outcome& outcome, SolveReport& report);
    void reportShortfall(SolveReport& report) const;
    void keep(const ControlPoints& points, const SolveReport& report, Eigen::VectorXcf& q);
    SolveReport
    silent(SolveReport report, StopReason stop, std::string why, int m, Eigen::VectorXcf& q);

    std::string _name;
    SolverOptions _options;
    double _louder = 0.0; // 0 .. 1; of the way to the loudest field, as the options ask
    double _beyond = 0.0; // the same for the targets at hand: 0 for absolute ones
    bool _absolute = false;
    double _audibleShare = 0.0; // of the drive's change, at the options' rate
    SplitVector _keptU;         // n
    Eigen::VectorXf _keptA;     // n
    FieldProblem _field;
    std::vector<int> _active, _lastActive;
    Eigen::VectorXd _lastTargets;
    SplitVector _last;       // the same, padded with zeros
    Eigen::VectorXcf _lastQ; // m, as the device played it; empty before the first field
    SolveReport _lastReport;
    bool _lastGood = false;
    float _largestTarget = 1.0f; // what the targets were divided by
};

} // namespace midair::haptics
