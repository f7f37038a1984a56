#pragma once

#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/production/ShapedRounding.h"

#include <algorithm>
#include <array>
#include <memory>

namespace midair::haptics
{

/// Constants of the production solver. They are members only so that midair-constants-bench can
/// vary them. The sections of haptics/SOLVER.md named below explain each constant and give the
/// benchmark's figures.
struct GaussNewtonTuning
{
    // "Rounds"
    float mostReweighing = 5.0f; ///< largest factor on a weight in one round

    // "Cold start"
    int coldStarts = 3;          ///< sets of starting phases
    int trialRounds = 10;        ///< rounds of each start before the loudest is chosen
    int coldRounds = 30;         ///< rounds of the loudest start, including its trial rounds
    int roundsBeforeWeights = 3; ///< first rounds, in which the weights equal the targets

    // "Warm start"
    int quietRounds = 2;       ///< maximum number of extra rounds for a field that became quieter
    float quiet = 0.996f;      ///< share of the recent loudness below which extra rounds are made
    float forget = 0.9998f;    ///< factor on the remembered loudness per update
    float targetsJump = 0.25f; ///< relative change of the targets, some of them quiet, that counts
                               ///< as a jump
    float lost = 0.97f;        ///< share of the last loudness below which an update starts cold

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
    float shapeable = 0.6f; ///< error over roundingError() up to which shaped rounding can correct
                            ///< it
    float levelMargin = 1e-4f; ///< relative error of a level in Pa that counts as zero
    float poorUpdate = 0.01f;  ///< rms error above which an update is repeated from a cold start
    float poorAgain = 2.0f; ///< error over that of the last such start above which another is worth
                            ///< it

    // "Rounding"
    ShapedRounding::Effort quick{0.25f, 3, 0.7f}; ///< of an update
    float leastPerPoint = 2.5f; ///< minimum number of transducers per point, instead of quick.share
    float mostPerPoint = 20.0f; ///< maximum number of transducers per point
    ShapedRounding::Effort thorough{1.0f, 3, 1.5f}; ///< of a cold start, and of crowded points

    int quietPasses = 2; ///< factor on the passes where points are quiet

    // "Crowded points"
    float crowded = 0.7f; ///< wavelengths to the nearest other point, below which they crowd
    int damped = 8;       ///< maximum number of damped steps of an update
    int dampedConjugateSteps = 24; ///< maximum number of CG steps in each
    float recovery = 1.0005f;      ///< factor on the level per update
    float yield = 0.9985f;         ///< smallest factor on it if the error requires less
    float leastKept = 0.7f;        ///< loudness, over the first, below which phases are discarded
    int coldDamped = 60;           ///< maximum number of damped steps of a descent from nothing
    float leastCold = 0.6f;        ///< smallest factor on its level
    float poor = 0.02f;            ///< error above which powerful, then smooth phases are tried
    int powerfulStarts = 4;        ///< number of transducers whose waves begin powerful phases
    int powerRounds = 60;          ///< rounds of each
    float powerfulLevel = 0.9f;    ///< starting level, over that of their projection
    int smoothStarts = 6;          ///< number of transducers whose waves are tried
    int smoothTrial = 8;           ///< damped steps of each before the best is chosen
    float smoothLevel = 0.2f;      ///< starting level, over that of their phases alone
    float leastSmooth = 0.5f;      ///< smallest factor on it
    float fair = 2e-3f;            ///< error above which the level is lowered
    int lowerings = 4;             ///< maximum number of lowerings
    float lowering = 0.9f;         ///< factor on the level each time
    int raisings = 40;             ///< maximum number of raisings, while the error is below fair
    float raising = 1.15f;         ///< factor on the level; its root after each failure
    float leastRaising = 1.02f;    ///< smallest factor
    float loud = 1.0f;             ///< loudness from which it is not raised

    // "CG tolerance"
    float farTolerance = 0.5f;  ///< CG tolerance over the rms error, if that is > searchAbove
    float nextTolerance = 0.4f; ///< CG tolerance over the error before the next correction
    float lastTolerance = 0.6f; ///< CG tolerance over the attainable error

    // "Coarse tolerances"
    float enough = 0.5f;     ///< share of the tolerance that the error may have before rounding
    float unshaped = 0.8f;   ///< share of it up to which rounding isn't shaped
    float spareQuiet = 0.9f; ///< in place of quiet, while amplitudes in Pa aren't full

    // "Amplitudes"
    int shapePasses = 3; ///< passes that fit the factor on |z_i| before the corrections
};

/// Makes the production solver with the constants \a tuning.
std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options,
                                                const GaussNewtonTuning& tuning);

/// Keeps a deadline: predicts the duration of a solve's stages from earlier solves, so that the
/// last field is finished in time (SOLVER.md, "Deadline").
class Pace
{
public:
    enum Stage
    {
        BUILD,    ///< building G
        ROUND,    ///< a round of projections
        STEP,     ///< a CG step
        FINISH,   ///< rounding and measuring what is played
        THOROUGH, ///< the same with thorough shaping
        STAGES
    };

    /// Begins a solve. \a deadline_ms counts from FieldProblem::start(); 0: none.
    void start(const FieldProblem& field, double deadline_ms)
    {
        _field = &field;
        _deadline_ms = deadline_ms;
        const double entries = static_cast<double>(field.n()) * field.m();
        for (std::size_t k = 0; deadline_ms > 0.0 && k < STAGES; ++k)
            _cost_ms[k] = entries != _entries ? kGuess_ms[k] * entries : kForget * _cost_ms[k];
        _entries = entries;
    }
    /// Returns how many times \a stage fits before the finish, 0 .. \a most; \a most without a
    /// deadline.
    int fits(Stage stage, int most) const
    {
        if (_deadline_ms <= 0.0) return most;
        const double count = left_ms(FINISH) / _cost_ms[stage];
        return static_cast<int>(std::clamp(count, 0.0, static_cast<double>(most)));
    }
    /// Returns true if so little time is left that a round must be the finish. \a isBuilt: G is
    /// built.
    bool isHurried(bool isBuilt) const
    {
        return _deadline_ms > 0.0 &&
               left_ms(FINISH) < (isBuilt ? 0.0 : _cost_ms[BUILD]) + _cost_ms[ROUND];
    }
    /// Returns true if \a finish can still begin in time.
    bool allows(Stage finish) const { return _deadline_ms <= 0.0 || left_ms(finish) >= 0.0; }
    /// Does \a work, which is \a count times \a stage, and records its duration.
    template<typename Work>
    void timed(Stage stage, int count, const Work& work)
    {
        if (_deadline_ms <= 0.0) return work();
        const double start = _field->elapsed_ms();
        work();
        took(stage, count, _field->elapsed_ms() - start);
    }
    /// Records that \a count times \a stage took \a ms; ignored if \a count is 0.
    void took(Stage stage, int count, double ms)
    {
        if (count <= 0) return;
        double& cost_ms = _cost_ms[stage];
        cost_ms += kMemory * (std::min(ms / count, kMostGrowth * cost_ms) - cost_ms);
    }

private:
    double left_ms(Stage finish) const
    {
        return _deadline_ms - _field->elapsed_ms() - _cost_ms[finish];
    }

    // SOLVER.md, "Deadline". A stage that is slow because the machine is briefly busy counts
    // little, and one skipped for lack of time is tried again.
    static constexpr std::array<double, STAGES> kGuess_ms = {
        1e-6, 2e-7, 8e-8, 3e-7, 8e-7};         // per entry
    static constexpr double kMemory = 0.3;     // weight of the last duration
    static constexpr double kMostGrowth = 2.0; // relative to the stored duration
    static constexpr double kForget = 0.98;    // per solve

    const FieldProblem* _field = nullptr;
    double _deadline_ms = 0.0, _entries = 0.0;
    std::array<double, STAGES> _cost_ms{};
};

} // namespace midair::haptics
