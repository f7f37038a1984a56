#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <vector>

namespace midair::haptics
{

/// Solves fields that are played in turn, each for a part of the points or an instant of their
/// modulation. They are solved one by one and then brought to a common level, so that targets are
/// comparable across fields.
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
    /// level_Pa where the target is largest. It is REFUSED if a part is, and STOPPED, with all
    /// fields zero, if a part is. Throws InputError for no parts and for more than
    /// kMostPointsInTurn points.
    SolveReport solve(const std::vector<ControlPoints>& parts,
                      const TransducerArray& array,
                      const Medium& medium,
                      std::vector<Eigen::VectorXcf>& fields);

    /// HologramSolver::achieved_Pa() of the last solve(); empty for several fields.
    Eigen::VectorXf achieved_Pa() const;

    /// Replaces the options of all solvers so far; returns false if one of them can't.
    bool setOptions(const SolverOptions& options);

private:
    Factory _makeSolver;
    std::vector<std::unique_ptr<HologramSolver>> _solvers;
    std::vector<SolveReport> _reports;
};

/// Returns the level, Pa per unit of target, that a field with \a report plays at its \a points; 0
/// if nothing is played.
double unitLevel(const SolveReport& report, const ControlPoints& points);

/// Returns the common report of fields that are played in turn, from their \a reports (>= 1).
SolveReport together(const std::vector<SolveReport>& reports);

} // namespace midair::haptics
