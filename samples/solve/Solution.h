#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/sequence/FieldSequence.h"
#include "samples/solve/SolveEars.h"
#include "samples/solve/SolveFiles.h"
#include "samples/solve/SolveOptions.h"
#include "samples/solve/SolvePoints.h"
#include "samples/solve/SolveProbe.h"

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <vector>

namespace midair::samples
{

/// All results that are written to files.
struct Solution
{
    SolveScene scene;
    haptics::FieldSequence sequence;          ///< as the written drives play it
    std::vector<device::DriveSignal> signals; ///< one per field
    haptics::ControlPoints points;            ///< points of the sequence
    /// n, computed in double from the encoded drive; each point in the field made for it
    Eigen::VectorXd achieved_Pa;
    Eigen::VectorXd target_Pa; ///< n; relative targets are at the level that was reached
    SummaryParts parts;
    std::optional<ProbeTraces> probe;                 ///< if it was asked for
    std::optional<haptics::ToleranceStudy> tolerance; ///< likewise
    std::shared_ptr<const SolveEars> ears;
};

/// Samples the model, selects points, composes the fields, applies the cap and measures the result.
/// Throws base::InputError.
Solution solveAll(const SolveArguments& arguments);

} // namespace midair::samples
