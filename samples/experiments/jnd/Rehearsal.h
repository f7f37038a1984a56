#pragma once

#include "samples/experiments/jnd/Staircase.h"

#include <cstdint>
#include <string>

namespace midair::samples
{

/// Somebody whose threshold is known, to try the procedure: feels a difference x with probability
///     lapse/2 + (1 - lapse) Phi((x - threshold)/spread),
/// Phi the normal distribution, so that x = threshold is felt in half of all trials.
struct SimulatedParticipant
{
    double threshold = 0.0;
    double spread = 1.0; ///< > 0, standard deviation of Phi; its slope is 1/(spread sqrt(2 pi))
    double lapse = 0.02; ///< 0 .. 1: share of trials that are answered by a coin
    std::uint64_t seed = 1;

    double chance(double value) const;

    /// Returns the answer in trial \a trial, from 1. It depends on what is given here alone, so a
    /// run that goes on after it was killed has the answers of one that wasn't.
    bool feels(int trial, double value) const;
};

/// Returns what is wrong with it, as a sentence; empty: nothing.
std::string problemOf(const SimulatedParticipant& participant);

/// How well a threshold that is known is found.
struct Recovery
{
    double bias = 0.0;      ///< mean of found less true
    double biasError = 0.0; ///< standard error of that mean
    double deviation = 0.0; ///< standard deviation of what is found, over n - 1
    double within = 0.0;    ///< share of sessions that are off by at most the participant's spread
};

/// What came of many sessions with simulated participants.
struct Rehearsal
{
    Recovery fit;         ///< by PsychometricFit
    Recovery turns;       ///< by the mean of the turns
    double covered = 0.0; ///< share of sessions that are off by at most 1.96 thresholdError
    double bounded = 0.0; ///< share with a turn at an end of the range, which count as the others
    double trials = 0.0;  ///< mean number in a session
};

/// Leads \a participant through \a sessions, > 1, without fields, with its seed and those that
/// follow it.
Rehearsal
rehearse(SimulatedParticipant participant, const StaircaseSettings& settings, int sessions);

} // namespace midair::samples
