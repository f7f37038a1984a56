#pragma once

#include "samples/experiments/jnd/TrialFile.h"

#include <vector>

namespace midair::samples
{

/// What all answers say of somebody's threshold and spread: the chance to feel a difference x is
/// that of SimulatedParticipant, with a lapse of kFitLapse. Posterior means and deviations, for
/// thresholds that are equally likely from 0 to the maximum and spreads that are equally likely on
/// a logarithmic axis from a quarter of a step to a quarter of the maximum. Which values were asked
/// depends on answers alone, so the likelihood doesn't ask how the staircase went.
struct PsychometricFit
{
    double threshold = 0.0;
    double thresholdError = 0.0; ///< standard deviation of the posterior
    double spread = 0.0;         ///< geometric mean
};

/// Share of trials in which people are thought to answer by chance.
constexpr double kFitLapse = 0.02;

/// Fits \a trials, of which there is at least one.
PsychometricFit fitTrials(const std::vector<Trial>& trials, const StaircaseSettings& settings);

} // namespace midair::samples
