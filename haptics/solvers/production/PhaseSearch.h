#pragma once

#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/production/GaussNewtonStep.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "haptics/solvers/production/QuietPoints.h"

#include <cstdint>
#include <vector>

namespace midair::haptics
{

/// Finds phases by alternating projections (SOLVER.md, "Rounds", "Cold start", "Warm start"), and
/// keeps the points' multipliers c between updates: the weight w of c = w u, or c itself for a
/// quiet point.
class PhaseSearch
{
public:
    explicit PhaseSearch(const GaussNewtonTuning& tuning) :
        _tuning(tuning),
        _leastShare(tuning.quiet)
    {
    }

    /// Builds G and makes the first round of a warm start in the same pass, if the number of
    /// weights matches.
    void build(FieldProblem& field);
    /// Gives point l the weight of the last field's point \a lastOf[l]; new points (-1) get the
    /// mean weight for their target. Returns false if there are no weights.
    bool carryOver(const FieldProblem& field, const std::vector<int>& lastOf);
    /// Sets whether weights follow changed targets (default: true).
    void followTargets(bool follow) { _follows = follow; }
    /// Sets the share of the recent loudness below which an update gets extra rounds (default:
    /// GaussNewtonTuning::quiet).
    void keepLouderThan(float share) { _leastShare = share; }
    /// Leaves q = z/|z| with its p, y and u in \a field. Starts cold unless \a warm, and returns
    /// the number of rounds, at least one and about \a limit at most. wasCold() then tells whether
    /// it started cold.
    int search(FieldProblem& field, bool warm, int limit, std::uint64_t seed, Pace& pace);
    bool wasCold() const { return _wasCold; }

    /// Returns c (n) of \a field; empty if that has another number of points.
    Eigen::VectorXcf multipliers(const FieldProblem& field) const;
    /// Replaces c by \a c (n), and makes later updates compare their loudness with that of the next
    /// field. Returns false if there are no multipliers of that number.
    bool take(FieldProblem& field, const Eigen::VectorXcf& c);
    /// Sets the multipliers of a start from nothing, whose phases are field.u.
    void begin(const FieldProblem& field);
    /// Makes \a count rounds that adapt the multipliers, and then one that leaves their q, p, y and
    /// u in \a field.
    void improve(FieldProblem& field, int count, Pace& pace);

    /// Returns s with sum_l w_l (s a_l - |p_l|) = 0, the only level that a correction can reach
    /// (SOLVER.md, "The level of a correction"); Pa at a_l = 1.
    float naturalLevel(const FieldProblem& field) const;
    /// Points of this solve whose targets are far below the largest.
    const QuietPoints& quiet() const { return _quiet; }
    /// Returns w for GaussNewtonStep::solve().
    const Eigen::VectorXf& weights(const FieldProblem& field);
    /// Adds \a amplitude times the multipliers of \a step to c; w_l decreases at most to
    /// leastOfWeight times its value.
    void adjust(const GaussNewtonStep& step, float amplitude);
    /// Turns the multipliers with the phases of the field.
    void turn(std::complex<float> by);
    void normalise();

private:
    void reserve(const FieldProblem& field);
    void weighByTargets(const FieldProblem& field);
    void adapt(const FieldProblem& field, const Eigen::VectorXf& targets);
    void weigh(FieldProblem& field) const;
    void reweigh(FieldProblem& field);
    float alongPhase(const FieldProblem& field, int l) const
    {
        const auto row = static_cast<std::size_t>(l);
        return std::real(_multiplier.at(row) * std::conj(field.u.at(row)));
    }
    int coldStart(FieldProblem& field, int limit, std::uint64_t seed, Pace& pace);
    int keepLoud(FieldProblem& field, int limit, Pace& pace);
    int rounds(FieldProblem& field, int first, int last, Pace& pace);
    void round(FieldProblem& field, Pace& pace);
    float loudness(const FieldProblem& field) const;

    const GaussNewtonTuning& _tuning;
    SplitVector _startU, _bestU; // n
    QuietPoints _quiet;
    Eigen::VectorXf _weights, _bestWeights;   // n; 0 for quiet points
    SplitVector _multiplier, _bestMultiplier; // n; used for quiet points only
    Eigen::VectorXf _targets;                 // n, targets of both
    Eigen::VectorXf _rows;                    // of weights()
    float _loudest = 0.0f;   // largest recent loudness, times forget per update since
    float _previous = 0.0f;  // loudness of the last update
    int _weightsOf = 0;      // number of points of the weights
    bool _projected = false; // build() made the first round
    bool _wasCold = true;
    bool _follows = true; // weights follow the targets
    float _leastShare;    // of the recent loudness
    bool _isJump = false; // jump of the targets since the last field
};

} // namespace midair::haptics
