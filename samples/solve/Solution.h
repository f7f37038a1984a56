#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/sequence/FieldSequence.h"
#include "samples/solve/SolveFiles.h"
#include "samples/solve/SolveOptions.h"
#include "samples/solve/SolvePoints.h"

#include <Eigen/Core>

#include <vector>

namespace midair::samples
{

/// Everything that is written, kept together until the files are.
struct Solution
{
    SolveScene scene;
    haptics::FieldSequence sequence;          ///< as the drives that are written play it
    std::vector<device::DriveSignal> signals; ///< one a field
    haptics::ControlPoints points;            ///< of the sequence
    Eigen::VectorXd
        achieved_Pa;           ///< n, in double from the encoded drive; in the field for the point
    Eigen::VectorXd target_Pa; ///< n; relative targets at the level that was reached
    SummaryParts parts;
};

/// Samples, selects, composes, caps, measures. Throws base::InputError.
Solution solveAll(const SolveArguments& arguments);

} // namespace midair::samples
