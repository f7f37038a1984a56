#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <memory>

namespace midair::haptics
{

/// The constants of the production solver. They are members so that midair-constants-bench can
/// vary them; nothing else should. haptics/SOLVER.md explains each in the section that is named,
/// with what the benchmark printed.
struct GaussNewtonTuning
{
    // "Rounds"
    float mostReweighing = 5.0f; ///< factor by which a weight changes in a round, at most

    // "Cold start"
    int coldStarts = 3;
    int trialRounds = 10;        ///< of each start
    int coldRounds = 30;         ///< of the best start, its trial rounds among them
    int roundsBeforeWeights = 3; ///< the weights stay what the targets are

    // "Warm start"
    int quietRounds = 2;    ///< further rounds that a field which has become quieter gets
    float quiet = 0.996f;   ///< of the loudness lately: below, a field has become quieter
    float forget = 0.9998f; ///< what is left of the loudness lately after an update

    // "The step"
    float largestTurn_rad = 0.5f; ///< of a transducer's phase in one correction
    float mostFreedom = 4.0f;     ///< cap on 1/|z_i|, over its mean

    // "Corrections"
    int corrections = 8;         ///< of a solve, at most
    int conjugateSteps = 12;     ///< of each correction, at most
    float searchAbove = 0.1f;    ///< rms above which a step is searched for
    float leastOfWeight = 0.02f; ///< that a correction leaves of a weight
    float roundingMargin = 1.3f; ///< an error below this times rounding's counts as rounding
    float stepFractions[3] = {1.0f, 0.3f, 0.1f}; ///< that the search tries

    // "CG tolerance"
    float farTolerance = 0.5f;   ///< over the rms, above searchAbove
    float nextTolerance = 0.4f;  ///< over the next correction's first error
    float lastTolerance = 0.45f; ///< over what is reached at best

    // "Amplitudes"
    int shapePasses = 3;
    int settlePasses = 4;
};

/// The production solver with other constants than its own.
std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options,
                                                const GaussNewtonTuning& tuning);

} // namespace midair::haptics
