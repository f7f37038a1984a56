#pragma once

#include "samples/installations/jnd/SimulatedParticipant.h"
#include "samples/installations/jnd/Staircase.h"

namespace midair::samples
{

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
