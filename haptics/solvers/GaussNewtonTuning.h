#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <memory>

namespace midair::haptics
{

/// The constants of the production solver. They are members so that midair-constants-bench can
/// vary them; nothing else should. The sections of haptics/SOLVER.md named below explain each
/// constant and give the benchmark's figures.
struct GaussNewtonTuning
{
    // "Rounds"
    float mostReweighing = 5.0f; ///< largest factor by which a round changes a weight

    // "Cold start"
    int coldStarts = 3;          ///< sets of starting phases
    int trialRounds = 10;        ///< rounds of each start before the loudest is chosen
    int coldRounds = 30;         ///< rounds of the loudest start, its trial rounds included
    int roundsBeforeWeights = 3; ///< rounds during which the weights equal the targets

    // "Warm start"
    int quietRounds = 2;    ///< largest number of further rounds for a field that became quieter
    float quiet = 0.996f;   ///< share of the recent loudness below which more rounds are made
    float forget = 0.9998f; ///< factor on the remembered loudness per update

    // "The step"
    float largestTurn_rad = 0.5f; ///< largest change of a transducer's phase in one correction
    float mostFreedom = 4.0f;     ///< cap on 1/|z_i|, relative to its mean

    // "Corrections"
    int corrections = 8;         ///< largest number of corrections in a solve
    int conjugateSteps = 12;     ///< largest number of CG steps in a correction
    float searchAbove = 0.1f;    ///< rms error above which a line search chooses the step's length
    float leastOfWeight = 0.02f; ///< least factor by which a correction may lower a weight
    float roundingMargin = 1.3f; ///< error over roundingError() below which all is rounding
    float stepFractions[3] = {1.0f, 0.3f, 0.1f}; ///< fractions of a step that the search tries

    // "CG tolerance"
    float farTolerance = 0.5f;   ///< CG tolerance over the rms error, where that is > searchAbove
    float nextTolerance = 0.4f;  ///< CG tolerance over the error before the next correction
    float lastTolerance = 0.45f; ///< CG tolerance over the attainable error

    // "Amplitudes"
    int shapePasses = 3;  ///< passes that fit the factor on |z_i| before the corrections
    int settlePasses = 4; ///< largest number of passes that fit the level after the corrections
};

/// Makes the production solver with the constants of \a tuning in place of its own.
std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options,
                                                const GaussNewtonTuning& tuning);

} // namespace midair::haptics
