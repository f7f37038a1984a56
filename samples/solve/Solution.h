#pragma once

#include "device/DriveSignal.h"
#include "samples/solve/SolveFiles.h"
#include "samples/solve/SolveOptions.h"
#include "samples/solve/SolveTurns.h"

#include <Eigen/Geometry>

#include <vector>

namespace midair::samples
{

/// Everything that is written, kept together until the files are.
struct Solution
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    haptics::TriangleMesh mesh; ///< empty where the points came from a file
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    haptics::ControlPoints points;
    bool absolute = false; ///< targets are in Pa
    haptics::SolveReport report;
    device::DriveSignal signal;
    Eigen::VectorXcf played; ///< m, what the encoded drive plays; of fields in turn the first
    Eigen::VectorXd
        achieved_Pa;           ///< n, in double from the encoded drive; in the field for the point
    Eigen::VectorXd target_Pa; ///< n
    Turns turns;               ///< no fields: a single one, by a solver
    std::vector<device::DriveSignal> signals; ///< of the fields in turn
    SummaryParts parts;
};

/// Samples, selects, solves, measures. Throws base::InputError.
Solution solveAll(const SolveArguments& arguments);

} // namespace midair::samples
