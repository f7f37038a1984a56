#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <vector>

namespace midair::haptics
{

/// Fields that are played in turn as one, each for its own part of the points or its own instant of
/// their modulation: solved one by one, then brought to a common level, so that targets compare
/// across fields as they do within one.
class TimeMultiplexer
{
public:
    using Factory = std::function<std::unique_ptr<HologramSolver>()>;

    /// \a makeSolver is called once a field, so that each field starts warm from its own last one.
    explicit TimeMultiplexer(Factory makeSolver) : _makeSolver(std::move(makeSolver)) {}

    /// One field for each of \a parts (>= 1), in their order, into \a fields (m activations each,
    /// on the array's levels). With relative targets the loudest that the weakest field allows;
    /// with absolute ones each as loud as it is to be. A part without points is silent. The report
    /// is of all together: rms and max over all points, sums of times and counts, level_Pa where
    /// the target is largest. REFUSED where a part is, STOPPED with all fields zero where one is.
    /// Throws InputError for no parts and for more than kMostPointsInTurn points.
    SolveReport solve(const std::vector<ControlPoints>& parts,
                      const TransducerArray& array,
                      const Medium& medium,
                      std::vector<Eigen::VectorXcf>& fields);

private:
    Factory _makeSolver;
    std::vector<std::unique_ptr<HologramSolver>> _solvers;
    std::vector<SolveReport> _reports;
};

/// Pa per unit of target that a field of \a report plays at \a points, which it was solved for; 0
/// where nothing is played.
double unitLevel(const SolveReport& report, const ControlPoints& points);

/// The report of all fields that are played in turn together, from \a reports (>= 1) of each.
SolveReport together(const std::vector<SolveReport>& reports);

} // namespace midair::haptics
