#pragma once

#include "engine-bridge/solving/OneSolve.h"
#include "samples/tools/solve/SolveEars.h"
#include "samples/tools/solve/SolveFiles.h"
#include "samples/tools/solve/SolveOptions.h"
#include "samples/tools/solve/SolvePoints.h"
#include "samples/tools/solve/SolveProbe.h"

#include <memory>
#include <optional>

namespace midair::samples
{

/// All results that are written to files.
struct Solution : bridge::SolvedFields
{
    SolveScene scene;
    SummaryParts parts;
    std::optional<ProbeTraces> probe;                 ///< if it was asked for
    std::optional<haptics::ToleranceStudy> tolerance; ///< likewise
    std::shared_ptr<const SolveEars> ears;
};

/// Samples the model, selects points, composes the fields, applies the cap and measures the result.
/// Throws base::InputError.
Solution solveAll(const SolveArguments& arguments);

} // namespace midair::samples
