#pragma once

#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/OutlineHologram.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::samples
{

/// Fields that are played in turn, or a single one, and the points that each is for.
struct Turns
{
    std::vector<Eigen::VectorXcf> fields; ///< m each
    std::vector<haptics::ControlPoints>
        parts;                   ///< of the first fields; steps between fields have none
    haptics::SolveReport report; ///< of all together
};

/// How sets of points become fields.
struct TurnOptions
{
    std::string solver;
    haptics::SolverOptions solverOptions;
    int subsets = 1;    ///< of each set, in turn
    int cycleSteps = 0; ///< between one field and the next, where there are no subsets
    int sweeps = 0;     ///< in which the fields are evened out together, where there are no subsets
    double fieldRate_Hz = 1000.0;
};

/// One field for each of \a sets, or for each subset of each. Throws base::InputError where one is refused.
Turns solveInTurn(const std::vector<haptics::ControlPoints>& sets,
                  const TurnOptions& options,
                  const Eigen::Matrix3Xd& surface,
                  const haptics::TransducerArray& array,
                  const haptics::Medium& medium);

/// The feature edges of \a mesh in one stationary field of dense points; \a pressure_Pa > 0: no louder than that.
Turns solveOutlines(const haptics::TriangleMesh& mesh,
                    const Eigen::Isometry3d& pose,
                    double pressure_Pa,
                    const haptics::TransducerArray& array,
                    const haptics::Medium& medium);

} // namespace midair::samples
