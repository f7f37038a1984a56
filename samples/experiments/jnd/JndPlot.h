#pragma once

#include "samples/experiments/jnd/TrialFile.h"
#include "samples/shared/views/CurvePlot.h"

#include <vector>

namespace midair::samples
{

/// Returns the plot of a session, begun or finished, with at least one trial: the staircase with
/// the paper's threshold beside the one that was found, and below it the share of "yes" at each
/// value with the fitted curve.
CurvePlot plotOf(const TrialFile& session);

/// Returns the plot of finished sessions of one experiment: each threshold with its uncertainty,
/// their mean and standard deviation beside the paper's.
CurvePlot plotOf(const std::vector<TrialFile>& sessions);

/// Mean and standard deviation (over n - 1; 0 for one) of what the sessions found.
struct GroupThreshold
{
    double mean = 0.0, deviation = 0.0;
};
GroupThreshold groupOf(const std::vector<TrialFile>& sessions);

} // namespace midair::samples
