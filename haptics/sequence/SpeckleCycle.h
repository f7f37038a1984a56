#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/LevenbergMarquardt.h"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// How a cycle of fields is made; isValid() names the first violated constraint.
struct SpeckleCycleOptions
{
    std::string solver;          ///< a name that makeSolver knows; empty: its default
    SolverOptions solverOptions; ///< of each field
    bool reorder = true;         ///< play the fields in the order in which they differ least
    int sweeps = 0;        ///< >= 0; over all fields, each evened out with the others given: even()
    int corrections = 2;   ///< >= 1; of LevenbergMarquardt for each field and sweep
    double loudness = 1.0; ///< > 0; mean pressure that sweeps aim at, over the first field's

    bool isValid(std::string* error = nullptr) const;
};

/// What playing a cycle does; averages over its steps, the one from the last field to the first among them.
struct SpeckleCycleReport
{
    int fields = 0;
    int points = 0;                 ///< of all fields together
    SurfaceStatistics alone;        ///< of the first field by itself
    SurfaceStatistics cycle;        ///< of all in turn
    double meanPhaseStep_rad = 0.0; ///< mean |change of phase| of the transducers in a step
    double driveChange =
        0.0; ///< sum_i |q_i - q_i before|^2 / sum_i |q_i|^2 of a step: the audible part
    double worstRms = 0.0; ///< of the fields at their own points, before any sweep
    double solve_ms = 0.0;
};

/// K fields that are played in turn so that the skin, which averages pressure, feels a surface without the speckle that
/// each of them has between its control points: each field is for its own, shifted set of points (sampleSurfaceSets).
///
/// even() goes further: all K fields together are descended on sum_l (1 - mean_k |p_l^k|^2 / s^2)^2 over dense points, one
/// field after the other with what the others give there.
class SpeckleCycle
{
public:
    /// Throws InputError for options that are not valid.
    explicit SpeckleCycle(const SpeckleCycleOptions& options = {});

    /// One field a set (K >= 1). \a surface (3 x n, a third of a wavelength apart or closer) is where the sweeps even out and
    /// where the report is taken; empty: neither. A set that was solved before is solved warm. Throws InputError for no
    /// sets and where a field is refused, Stopped where the solver options' token asks for it.
    const SpeckleCycleReport& solve(const std::vector<ControlPoints>& sets,
                                    const Eigen::Matrix3Xd& surface,
                                    const TransducerArray& array,
                                    const Medium& medium);

    /// Activations (m) as the device plays them, in the order in which they are to be played.
    const std::vector<Eigen::VectorXcf>& fields() const { return _fields; }
    /// The cycle with \a steps >= 0 more fields between one and the next, each transducer turning the shorter way.
    std::vector<Eigen::VectorXcf> smoothed(int steps) const
    {
        return smoothedFields(_fields, steps, _drive);
    }
    const SpeckleCycleReport& report() const { return _report; }
    /// Of each set, in the order of the sets, before any sweep.
    const std::vector<SolveReport>& reports() const { return _reports; }
    /// Which set the field at each place is for.
    const std::vector<int>& order() const { return _order; }

private:
    void even(const Eigen::Matrix3Xd& surface, const TransducerArray& array, const Medium& medium);

    SpeckleCycleOptions _options;
    std::vector<std::unique_ptr<HologramSolver>> _solvers; // one a set, so that each starts warm
    std::vector<Eigen::VectorXcf> _fields;
    DriveResolution _drive;
    FieldProblem _dense;
    LevenbergMarquardt _even;
    SpeckleCycleReport _report;
    std::vector<SolveReport> _reports;
    std::vector<int> _order;
};

} // namespace midair::haptics
