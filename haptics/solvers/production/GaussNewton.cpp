#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/production/CrowdedDescent.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "haptics/solvers/production/PhaseSearch.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr int kMostIterations = 1000; // the constants bound them below this
constexpr int kFromNothing = 60;      // maximum for a start from nothing

/// The production solver (haptics/SOLVER.md): alternating projections find good phases,
/// Gauss-Newton corrections of the transducers' phases meet the targets, and shaped rounding to the
/// device's levels disturbs them little.
class GaussNewton final : public SolverBase
{
public:
    GaussNewton(const SolverOptions& options, const GaussNewtonTuning& tuning) :
        SolverBase("gauss-newton", options, Storage::FIXED),
        _tuning(tuning),
        _search(_tuning),
        _step(_tuning.largestTurn_rad, _tuning.mostFreedom),
        _crowded(_tuning)
    {
    }

private:
    void build(FieldProblem& field) override
    {
        startPace(field, false);
        _isPaced = true;
        _search.build(field);
    }

    bool carryOver(const FieldProblem& field, const std::vector<int>& lastOf) override
    {
        return _search.carryOver(field, lastOf);
    }

    // The phases of crowded points are not those of multipliers.
    Eigen::VectorXcf multipliersOf(const FieldProblem& field) const override
    {
        return _isCrowded ? Eigen::VectorXcf() : _search.multipliers(field);
    }

    bool take(FieldProblem& field, const Eigen::VectorXcf& c) override
    {
        return !_isCrowded && _search.take(field, c);
    }

    void startPace(FieldProblem& field, bool isBuilt)
    {
        _pace.start(field, options().deadline_ms);
        _isHurried = _pace.isHurried(isBuilt);
        field.endRoundsOnLevels(_isHurried);
    }

    Outcome iterate(FieldProblem& field, bool warm) override
    {
        Outcome outcome;
        outcome.playable = outcome.measured = true;
        if (!_isPaced) startPace(field, true);
        _isPaced = false;
        _pace.took(Pace::BUILD, field.staleRows() < field.n() ? 0 : 1, field.build_ms());
        const int limit = iterationLimit(kMostIterations);
        _search.followTargets(!isShifted());
        // The level of coarse targets in Pa is reached by amplitudes, rarely by all of them.
        const bool isSpare = isAbsolute() && isCoarseTolerance(options().rmsTolerance) &&
                             !_drive.amplitudes.isFull();
        _search.keepLouderThan(isSpare ? _tuning.spareQuiet : _tuning.quiet);
        attempt(field, warm, limit, outcome);
        if (isLost(field, limit, outcome))
        {
            attempt(field, false, limit, outcome);
            _leftFromNothing = playedError(field);
        }
        _search.normalise();
        return outcome;
    }

    // Searches for phases, \a warm from the last ones, corrects and plays them.
    void attempt(FieldProblem& field, bool warm, int limit, Outcome& outcome)
    {
        const int rounds = std::max(1, limit - outcome.iterations - _tuning.corrections);
        outcome.iterations += _search.search(field, warm, rounds, options().seed, _pace);
        _search.turn(alignToLast(field, _isHurried ? field.drive().phaseLevels : 0));
        if (isCoarse(field) && approximate(field, limit, outcome)) return;
        begin(field);
        if (_drive.amplitudes.rms() == 0.0f) return; // too quiet: nothing is played
        const float error = quiet().bend(field, _search.naturalLevel(field));
        const int left = std::max(1, limit - outcome.iterations);
        if (_isHurried && !_drive.amplitudes.data())
            outcome.stop = verdict(field, rounding(field));
        else if (_pace.fits(Pace::STEP, 1) == 0)
            finish(field, nullptr, outcome);
        else if (_isCrowded || needsDescent(field, error) || field.G.hasOutside())
            descend(field, left, outcome);
        else
            correct(field, left, outcome);
    }

    // Returns true if the tolerance is so coarse that the searched phases need a few steps at most,
    // and plain rounding keeps it (SOLVER.md, "Coarse tolerances").
    bool isCoarse(const FieldProblem& field) const
    {
        const auto tolerance = static_cast<float>(options().rmsTolerance);
        if (!isCoarseTolerance(options().rmsTolerance) || !options().phaseOnly || quiet().any() ||
            _isHurried || _isCrowded || field.drive().phaseLevels == 0)
            return false;
        return roundingError(field, 1.0f) <= _tuning.unshaped * tolerance &&
               !needsDescent(field, errorOf(field, _search.naturalLevel(field)));
    }

    // Steps at full drive until the error before rounding is a share of the tolerance, then chooses
    // the amplitudes for the level and plays. Returns false, with nothing played, if a mix of
    // amplitude levels disturbs more than rounding may.
    bool approximate(FieldProblem& field, int limit, Outcome& outcome)
    {
        const float goal = _tuning.enough * static_cast<float>(options().rmsTolerance);
        float error = errorOf(field, _search.naturalLevel(field));
        for (int k = 0; error > goal && k < std::min(_tuning.corrections, limit); ++k)
        {
            solveStep(field, _tuning.enough * goal, _tuning.conjugateSteps);
            ++outcome.iterations;
            field.eachBlock(
                [&](int, int block)
                {
                    _step.turn(field, block, field.q);
                    field.forwardBlock(block, field.q);
                });
            field.sumPartials(field.p);
            field.phasesOf(field.p);
            _search.adjust(_step, 1.0f);
            error = errorOf(field, _search.naturalLevel(field));
        }
        _drive.begin(field);
        _drive.amplitudes.choose(field, wish(), _search.naturalLevel(field));
        if (_drive.amplitudes.rms() == 0.0f) return true; // too quiet: nothing is played
        const float disturbance = std::hypot(
            roundingError(field, 1.0f), errorOfSpread(field, 1.0f, _drive.amplitudes.spread()));
        if (disturbance > _tuning.unshaped * static_cast<float>(options().rmsTolerance))
            return false;
        constexpr ShapedRounding::Effort kPlain{0.0f, 1, 1.0f};
        _drive.play(field, quiet(), nullptr, kPlain);
        const float level = fittedLevel(field);
        if (isAbsolute() && std::fabs(largestTarget() / level - 1.0f) > goal &&
            _drive.amplitudes.scale(field, largestTarget() / level))
            _drive.play(field, quiet(), nullptr, kPlain);
        outcome.stop = verdict(field, rounding(field));
        outcome.unfinished = outcome.stop == StopReason::MAX_ITERATIONS;
        return true;
    }

    float playedError(const FieldProblem& field) const
    {
        return quiet().error(field, fittedLevel(field));
    }

    // Returns true if an update's corrections left an error that a start from nothing most likely
    // avoids: the last multipliers were useless, as after a jump of the targets.
    bool isLost(const FieldProblem& field, int limit, const Outcome& outcome) const
    {
        if (_search.wasCold() || outcome.stop != StopReason::MAX_ITERATIONS || _isCrowded ||
            field.G.hasOutside() || limit - outcome.iterations < kFromNothing)
            return false;
        return playedError(field) > std::max({_tuning.poorUpdate,
                                              _tuning.roundingMargin * rounding(field),
                                              _tuning.poorAgain * _leftFromNothing});
    }

    const QuietPoints& quiet() const { return _search.quiet(); }

    // Full steps overshoot if points crowd; otherwise a large error in the first round can be due
    // to their number or a long move.
    bool needsDescent(const FieldProblem& field, float error) const
    {
        const bool isFar = error > _tuning.searchApart && (!quiet().any() || _search.wasCold());
        return error > _tuning.searchAbove && (isFar || field.crowds(_tuning.crowded));
    }

    DriveAmplitudes::Wish wish() const
    {
        DriveAmplitudes::Wish wish;
        wish.phaseOnly = options().phaseOnly;
        wish.loudness = static_cast<float>(options().loudness);
        if (isAbsolute()) wish.level_Pa = largestTarget();
        return wish;
    }

    // Chooses amplitudes for the present phases and measures the drive.
    void begin(FieldProblem& field)
    {
        _drive.begin(field);
        _drive.amplitudes.choose(field, wish(), _search.naturalLevel(field));
        if (!_drive.amplitudes.data()) return;
        _drive.measure(field);
        for (int pass = 1; pass < _tuning.shapePasses; ++pass)
            settle(field, _search.naturalLevel(field));
    }

    // Targets in Pa: adjusts the level, now \a level, to the requested one, as far as the array is
    // loud enough, and measures the drive again if that changed it.
    void settle(FieldProblem& field, float level)
    {
        if (isAbsolute() && _drive.amplitudes.scale(field, largestTarget() / level))
            _drive.measure(field);
    }

    // Error of unshaped rounding, at any amplitude.
    float rounding(const FieldProblem& field) const
    {
        return quiet().rounding(field, _drive.amplitudes.rms());
    }

    // Returns the CG tolerance (SOLVER.md, "CG tolerance"): nextTolerance times the error before
    // the next correction, or farTolerance times the present error if the linearisation does not
    // hold, because late CG steps follow ill-conditioned directions. At least \a least, which
    // rounding or the options' tolerance determine.
    float toleranceOf(float error, float nextError, float least) const
    {
        return std::max(least,
                        error > _tuning.searchAbove ? _tuning.farTolerance * error
                                                    : _tuning.nextTolerance * nextError);
    }

    // Corrects until the played field is as exact as requested or its error is all rounding. A
    // correction leaves about the square of the rms error before it. If that is still too much,
    // another correction follows, so CG stops early and the phases are not rounded.
    void correct(FieldProblem& field, int limit, Outcome& outcome)
    {
        const auto tolerance = static_cast<float>(options().rmsTolerance);
        float kept = 1.0f; // share of the level that rounding leaves
        for (int k = 0; k < _tuning.corrections; ++k)
        {
            if (k > 0) settle(field, kept * _search.naturalLevel(field));
            const float floor = quiet().any()
                                    ? QuietPoints::disturbance(field, _drive.amplitudes.rms())
                                    : rounding(field);
            const float level = _search.naturalLevel(field);
            const float error = quiet().error(field, level), bend = quiet().bend(field, level);
            const int steps = _pace.fits(Pace::STEP, _tuning.conjugateSteps);
            const bool out = k + 1 >= std::min(_tuning.corrections, limit) || outOfTime(field) ||
                             steps < _tuning.conjugateSteps;
            const float next = error * bend; // after a full step
            const bool last = out || next < std::max(tolerance, _tuning.shapeable * floor);
            const float least = _tuning.lastTolerance * std::max(floor, tolerance);
            solveStep(field, toleranceOf(bend, last ? 0.0f : next, least), steps);
            ++outcome.iterations;
            if (last)
                finish(field, &_step, outcome);
            else
                _drive.turn(field, _step);
            // The step is that of c_l + x_l u_l for unit amplitudes; smaller ones take a larger
            // x_l.
            _search.adjust(_step, _drive.amplitudes.rms());
            if (out || (last && outcome.stop != StopReason::MAX_ITERATIONS)) return;
            if (!last) continue;
            const float played = _search.naturalLevel(field);
            _drive.measure(field);
            kept = played / _search.naturalLevel(field);
        }
    }

    void solveStep(FieldProblem& field, float tolerance, int steps)
    {
        const double start = field.elapsed_ms();
        const int made =
            _step.solve(field, field.q, quiet(), _search.weights(field), tolerance, steps);
        _pace.took(Pace::STEP, std::max(made, 1), field.elapsed_ms() - start);
    }

    // Plays the phases, after turning them by \a step if not null: thoroughly after a start from
    // nothing and on request, quickly in updates, in a hurry with plain rounding.
    void finish(FieldProblem& field, const GaussNewtonStep* step, Outcome& outcome)
    {
        const bool isWorthIt = options().thorough || _search.wasCold() || !step;
        const bool thorough = isWorthIt && _pace.allows(Pace::THOROUGH);
        const bool shaped = thorough || _pace.allows(Pace::FINISH);
        const ShapedRounding::Effort plain{0.0f, 1, 1.0f};
        const float floor = rounding(field);
        _pace.timed(thorough ? Pace::THOROUGH : Pace::FINISH,
                    shaped ? 1 : 0,
                    [&]
                    {
                        _drive.play(field,
                                    quiet(),
                                    step,
                                    thorough ? ofQuiet(_tuning.thorough)
                                    : shaped ? quick(field)
                                             : plain);
                    });
        outcome.stop = verdict(field, floor);
        outcome.unfinished =
            outcome.stop == StopReason::MAX_ITERATIONS || outcome.stop == StopReason::DEADLINE;
    }

    // Quiet points have extra weight, which takes more passes.
    ShapedRounding::Effort ofQuiet(ShapedRounding::Effort effort) const
    {
        if (quiet().any()) effort.passes *= _tuning.quietPasses;
        return effort;
    }

    // Shapes as many transducers as the number of points requires; none, if the share is 0.
    ShapedRounding::Effort quick(const FieldProblem& field) const
    {
        const float pointShare =
            static_cast<float>(field.n() + quiet().count()) / static_cast<float>(field.m());
        ShapedRounding::Effort effort = ofQuiet(_tuning.quick);
        if (effort.share == 0.0f) return effort;
        effort.share = std::min(effort.share, _tuning.mostPerPoint * pointShare);
        effort.share = std::min(std::max(effort.share, _tuning.leastPerPoint * pointShare), 1.0f);
        return effort;
    }

    // For points that crowd within a wavelength. They use this until an update's projection fits
    // better than the phases of the last one, and well enough to be corrected.
    void descend(FieldProblem& field, int limit, Outcome& outcome)
    {
        const float error = quiet().bend(field, _search.naturalLevel(field));
        CrowdedDescent::Wish wish;
        wish.goal = std::max(0.5f * static_cast<float>(options().rmsTolerance),
                             _tuning.lastTolerance * rounding(field));
        wish.steps = limit;
        wish.moved = !_search.wasCold();
        outcome.iterations += _crowded.descend(field,
                                               quiet(),
                                               _drive,
                                               _step,
                                               _pace,
                                               wish,
                                               [this](FieldProblem& started) { begin(started); });
        settle(field, fittedLevel(field));
        finish(field, nullptr, outcome);
        _isCrowded =
            (!_crowded.beganAnew() || error > _tuning.searchAbove) && field.crowds(_tuning.crowded);
        outcome.unfinished = outcome.stop != StopReason::CONVERGED;
    }

    // Returns the stop reason of the played field.
    StopReason verdict(const FieldProblem& field, float floor) const
    {
        const float level = fittedLevel(field);
        const float rms = quiet().error(field, level);
        const auto tolerance = static_cast<float>(options().rmsTolerance);
        const bool isRight = isLevelRight(field);
        if (isRight && errorOf(field, level) <= tolerance) return StopReason::CONVERGED;
        if (isRight &&
            rms < std::max(_tuning.roundingMargin * floor, quiet().any() ? tolerance : 0.0f))
            return StopReason::STALLED;
        return outOfTime(field) || _pace.fits(Pace::STEP, 1) == 0 ? StopReason::DEADLINE
                                                                  : StopReason::MAX_ITERATIONS;
    }

    // Returns false if the level is off by more than _tuning.levelMargin and can be corrected.
    bool isLevelRight(const FieldProblem& field) const
    {
        if (!isAbsolute()) return true;
        const float ratio = largestTarget() / fittedLevel(field);
        const double margin = isCoarseTolerance(options().rmsTolerance) ? options().rmsTolerance
                                                                        : _tuning.levelMargin;
        const float least =
            std::max(static_cast<float>(margin), _drive.amplitudes.leastChange(field));
        return std::fabs(ratio - 1.0f) < least || (ratio > 1.0f && _drive.amplitudes.isFull());
    }

    GaussNewtonTuning _tuning;
    Pace _pace;
    PhaseSearch _search;
    GaussNewtonStep _step;
    CorrectedDrive _drive;
    CrowdedDescent _crowded;
    bool _isCrowded = false;       // the last update was a descent
    bool _isPaced = false;         // since build()
    bool _isHurried = false;       // the present update ends with its last round
    float _leftFromNothing = 0.0f; // error of the last start from nothing that replaced an update
};

} // namespace

std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options)
{
    return makeGaussNewton(options, GaussNewtonTuning());
}

std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options,
                                                const GaussNewtonTuning& tuning)
{
    return std::make_unique<GaussNewton>(options, tuning);
}

} // namespace midair::haptics
