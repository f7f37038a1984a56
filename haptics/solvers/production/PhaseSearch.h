#pragma once

#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "haptics/solvers/production/Pace.h"

#include <cstdint>
#include <vector>

namespace midair::haptics
{

/// Finds phases by alternating projections (SOLVER.md, "Rounds", "Cold start", "Warm start"), and
/// keeps the weights w of the points from one update to the next.
class PhaseSearch
{
public:
    explicit PhaseSearch(const GaussNewtonTuning& tuning) : _tuning(tuning) {}

    /// Builds G and makes the first round of a warm start in the same pass, if the weights belong
    /// to as many points.
    void build(FieldProblem& field);
    /// Gives point l the weight of the last field's point \a lastOf[l]; new points (-1) get the
    /// mean weight for their target. Returns false without weights to take over.
    bool carryOver(const FieldProblem& field, const std::vector<int>& lastOf);
    /// Leaves q = z/|z| with its p, y and u in \a field. Starts from nothing unless \a warm, and
    /// returns the number of rounds, at least one and about \a limit at most. wasCold() then tells
    /// how it started.
    int search(FieldProblem& field, bool warm, int limit, std::uint64_t seed, Pace& pace);
    bool wasCold() const { return _wasCold; }

    /// Returns s with sum_l w_l (s a_l - |p_l|) = 0, the only level that a correction can reach
    /// (SOLVER.md, "The level of a correction"); Pa at a_l = 1.
    float naturalLevel(const FieldProblem& field) const;
    const Eigen::VectorXf& weights() const { return _weights; }
    /// Changes w_l by \a change(l), to no less than the leastOfWeight-fold.
    template<typename Change>
    void adjust(const Change& change)
    {
        for (Eigen::Index l = 0; l < _weights.size(); ++l)
            _weights[l] = std::max(_weights[l] + change(static_cast<int>(l)),
                                   _tuning.leastOfWeight * _weights[l]);
    }
    void normalise() { _weights /= _weights.mean(); }

private:
    int coldStart(FieldProblem& field, int limit, std::uint64_t seed, Pace& pace);
    int keepLoud(FieldProblem& field, int limit, Pace& pace);
    int rounds(FieldProblem& field, int first, int last, Pace& pace);
    void round(FieldProblem& field, Pace& pace);
    float loudness(const FieldProblem& field) const;

    const GaussNewtonTuning& _tuning;
    SplitVector _startU, _bestU; // n
    Eigen::VectorXf _weights, _bestWeights;
    float _loudest = 0.0f;   // largest recent loudness, times forget per update since
    float _previous = 0.0f;  // loudness of the last update
    int _weightsOf = 0;      // number of points that the weights belong to
    bool _projected = false; // build() has made the first round
    bool _wasCold = true;
};

} // namespace midair::haptics
