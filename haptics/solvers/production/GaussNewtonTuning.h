#pragma once

#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/production/ShapedRounding.h"

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
    int quietRounds = 2;       ///< largest number of further rounds for a field that became quieter
    float quiet = 0.996f;      ///< share of the recent loudness below which more rounds are made
    float forget = 0.9998f;    ///< factor on the remembered loudness per update
    float targetsJump = 0.25f; ///< relative change of the targets, some of them quiet, that is one
    float lost = 0.97f; ///< share of the last loudness below which an update starts from nothing

    // "The step"
    float largestTurn_rad = 1.0f; ///< largest change of a transducer's phase in one correction
    float mostFreedom = 4.0f;     ///< cap on 1/|z_i|, relative to its mean

    // "Corrections"
    int corrections = 8;         ///< largest number of corrections in a solve
    int conjugateSteps = 12;     ///< largest number of CG steps in a correction
    float searchAbove = 0.1f;    ///< rms error above which damped steps take over
    float searchApart = 0.35f;   ///< the same for points that do not crowd
    float leastOfWeight = 0.02f; ///< least factor by which a correction may lower a weight
    float roundingMargin = 1.3f; ///< error over roundingError() below which all is rounding
    float shapeable = 0.6f;      ///< error over roundingError() that shaped rounding can mend
    float levelMargin = 1e-4f;   ///< relative error of a level in Pa that counts as none
    float poorUpdate = 0.01f; ///< rms error of an update above which it starts from nothing instead
    float poorAgain = 2.0f;   ///< over what the last such start has left, above which another helps

    // "Rounding"
    ShapedRounding::Effort quick{0.25f, 3, 0.7f}; ///< of an update
    float leastPerPoint = 2.5f; ///< transducers for each point, at least, in place of quick.share
    float mostPerPoint = 20.0f; ///< and at most
    ShapedRounding::Effort thorough{1.0f, 3, 1.5f}; ///< of a cold start, and of crowded points

    int quietPasses = 2; ///< factor on the passes where points are quiet

    // "Crowded points"
    float crowded = 0.7f; ///< wavelengths to the nearest other point, below which they crowd
    int damped = 8;       ///< most damped steps of an update
    int dampedConjugateSteps = 24; ///< most CG steps of one
    float recovery = 1.0005f;      ///< factor on the level per update
    float yield = 0.9985f;         ///< least factor on it, where the error asks for less
    float leastKept = 0.7f;        ///< loudness, over the first, below which phases are given up
    int coldDamped = 60;           ///< most damped steps of a descent from nothing
    float leastCold = 0.6f;        ///< least factor on its level
    float poor = 0.02f;            ///< error above which smooth phases are tried
    int smoothStarts = 6;          ///< transducers whose waves are tried
    int smoothTrial = 8;           ///< damped steps of each before the best is chosen
    float smoothLevel = 0.2f;      ///< level they start from, over what their phases alone reach
    float leastSmooth = 0.5f;      ///< least factor on that
    float fair = 2e-3f;            ///< error above which the level is lowered
    int lowerings = 4;             ///< times that it may be lowered
    float lowering = 0.9f;         ///< factor on the level each time
    int raisings = 8;              ///< times that it may be raised where the error is below that
    float raising = 1.15f;         ///< factor on the level each time
    float loud = 1.0f;             ///< loudness from which it is not

    // "CG tolerance"
    float farTolerance = 0.5f;  ///< CG tolerance over the rms error, where that is > searchAbove
    float nextTolerance = 0.4f; ///< CG tolerance over the error before the next correction
    float lastTolerance = 0.6f; ///< CG tolerance over the attainable error

    // "Amplitudes"
    int shapePasses = 3; ///< passes that fit the factor on |z_i| before the corrections
};

/// Makes the production solver with the constants of \a tuning in place of its own.
std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options,
                                                const GaussNewtonTuning& tuning);

} // namespace midair::haptics
