#pragma once

#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/production/PhaseSearch.h"

#include <Eigen/Core>

#include <cstdint>
#include <random>
#include <vector>

namespace midair::haptics
{

/// Looks for multipliers of a louder field for points at rest (SOLVER.md, "Louder at rest"): it
/// turns a third of the points' phases at random, makes rounds, and keeps the result if it is
/// louder, again and again (iterated local search: Lourenco, Martin, Stuetzle 2003). Equal input
/// gives equal results. Works in steps of about two milliseconds.
class LouderPhases
{
public:
    /// Problems with more points are not searched.
    static constexpr int kMostPoints = 2000;

    /// Uses the seed, the pool or threads, and the stop token of \a options.
    explicit LouderPhases(const SolverOptions& options);
    LouderPhases(const LouderPhases&) = delete; // _search refers to _tuning
    LouderPhases& operator=(const LouderPhases&) = delete;

    /// Starts with the multipliers \a c of a solver's last field for valid \a points (n);
    /// hasWork() stays false if there are none, or too few or too many points.
    void begin(const ControlPoints& points,
               const TransducerArray& array,
               const Medium& medium,
               const Eigen::VectorXcf& c);
    bool hasWork() const { return _trials > 0; }
    /// Makes the next step. Throws base::Stopped on a stop request; the search can then go on.
    void step();
    void end() { _trials = 0; }

    /// Loudness of the best field so far over that of the given one, >= 1, before corrections.
    double gain() const { return _given > 0.0f ? static_cast<double>(_loudest / _given) : 1.0; }
    /// Multipliers of the best field so far (n).
    const Eigen::VectorXcf& best() const { return _best; }

private:
    void judge();
    void kick();

    const GaussNewtonTuning _tuning;
    FieldProblem _field;
    PhaseSearch _search;
    Pace _pace; // without a deadline
    const std::uint64_t _seed;
    std::mt19937_64 _random;
    std::vector<int> _active; // indices of the points that were solved for
    Eigen::VectorXcf _best;   // n
    float _given = 0.0f;      // level of the given field; 0: not measured yet
    float _loudest = 0.0f;    // level of the best
    bool _isBuilt = false;
    int _trials = 0; // remaining ones, including the present one
    int _rounds = 0; // remaining ones of the present trial
};

/// The way from a field's multipliers to those of a louder one, or from one field's activations to
/// another's. Each phase turns by the shorter angle, and each size changes evenly, so that the
/// fields on the way are accurate and hardly quieter. The length of a step follows the bounds.
class PhaseWalk
{
public:
    /// Largest step from one field to the next: mean change of a transducer's phase, and ratio of
    /// the levels. Most steps are a fifth of that.
    static constexpr double kMostTurn_rad = 0.15;
    static constexpr double kMostJump = 1.005;

    /// Lengths of steps, 0 .. 1.
    struct Steps
    {
        double first = 1.0 / 64; ///< of the whole way
        double meant = 0.2;      ///< share of the bounds that the next step is meant to use
    };

    PhaseWalk() = default;
    /// From \a from to \a to (n each), whose common size and phase don't count.
    PhaseWalk(const Eigen::VectorXcf& from, const Eigen::VectorXcf& to);
    /// From \a from to \a to (n each), where it ends.
    void begin(const Eigen::VectorXcf& from, const Eigen::VectorXcf& to, const Steps& steps);

    bool isOver() const { return !(_at < 1.0); }
    /// Multipliers from which the next field starts, or its activations (n).
    Eigen::VectorXcf next() const;
    /// Judges a field made from next(), which has \a turn_rad and \a jump from the present one.
    /// Returns true if it keeps the bounds: it is then the present one. Otherwise the next one is
    /// nearer; the walk ends if it can't be nearer still.
    bool accept(double turn_rad, double jump);
    void end() { _at = 1.0; }

private:
    Eigen::VectorXcf _from, _to; // n
    double _at = 1.0;            // 0 .. 1
    double _step = 0.0;
    double _meant = 0.0; // Steps::meant
};

} // namespace midair::haptics
