#include "haptics/base/Units.h"
#include "haptics/solvers/FieldFigures.h"
#include "haptics/solvers/GaussNewtonStep.h"
#include "haptics/solvers/GaussNewtonTuning.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/WeightedRound.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace midair::haptics
{

namespace
{

constexpr int kMostIterations = 1000; // never reached: the constants bound them at 59

/// The production solver (haptics/SOLVER.md): alternating projections find good phases, then
/// Gauss-Newton corrections of the transducers' phases meet the targets. Every field is q = z/|z|,
/// z = G* c with c_l = w_l u_l and u_l the phase of p_l. The solver keeps w and u from one update
/// to the next.
class GaussNewton final : public SolverBase
{
public:
    GaussNewton(const SolverOptions& options, const GaussNewtonTuning& tuning) :
        SolverBase("gauss-newton", options, Storage::FIXED),
        _tuning(tuning),
        _correction(tuning.largestTurn_rad, tuning.mostFreedom)
    {
    }

private:
    Outcome iterate(FieldProblem& field, bool warm) override
    {
        reserve(field);
        Outcome outcome;
        const int limit = iterationLimit(kMostIterations);
        _projected = _projected && warm;
        if (!warm || _weightsOf != field.n())
        {
            coldStart(field, std::max(1, limit - _tuning.corrections), outcome);
            _loudest = loudnessAt(field, naturalLevel(field));
        }
        _weightsOf = field.n();
        if (!_projected) projectionRound(field, _weights);
        if (warm) keepLoud(field, limit, outcome);
        _projected = false;
        ++outcome.iterations;
        alignToLast(field);
        chooseAmplitudes(field, naturalLevel(field));
        if (isLimited())
        {
            limitSteps();
            field.forward(field.q, field.p);
            field.phasesOf(field.p);
        }
        correct(field, limit, outcome);
        if (isAbsolute() && !isLimited()) settleLevel(field);
        _weights /= _weights.mean();
        outcome.playable = outcome.measured = !isLimited();
        return outcome;
    }

    void build(FieldProblem& field) override
    {
        _projected = _weightsOf == field.n();
        if (!_projected) return field.build();
        weighPhases(field, _weights);
        field.buildAndProject(field.w, field.p);
        field.phasesOf(field.p);
    }

    void reserve(const FieldProblem& field)
    {
        const std::size_t m = lanes(field);
        const auto n = static_cast<std::size_t>(field.n());
        for (SplitVector* v : {&_startU, &_bestU})
            v->reserve(n);
        _continuous.reserve(m);
        _before.reserve(m);
        _amplitudes.reserve(m);
        for (Eigen::VectorXf* v : {&_weights, &_bestWeights})
            if (v->size() != field.n()) v->resize(field.n());
    }

    // Returns s with sum_l w_l (s a_l - |p_l|) = 0, the only level that a correction can reach
    // (SOLVER.md, "The level of a correction").
    float naturalLevel(const FieldProblem& field) const
    {
        return weightedLevel(_weights, field.y, field.a);
    }

    // Phases that follow a moving object drift into a poorer local optimum than they started from.
    // A field that is quieter than the recent ones therefore gets further rounds, each of which
    // raises the loudness (SOLVER.md, "Warm start").
    void keepLoud(FieldProblem& field, int limit, Outcome& outcome)
    {
        for (int k = 0; k < _tuning.quietRounds &&
                        loudnessAt(field, naturalLevel(field)) < _tuning.quiet * _loudest &&
                        outcome.iterations + 2 < limit && !outOfTime(field);
             ++k)
        {
            reweigh(field, _weights, _tuning.mostReweighing);
            projectionRound(field, _weights);
            ++outcome.iterations;
        }
        _loudest = std::max(_tuning.forget * _loudest, loudnessAt(field, naturalLevel(field)));
    }

    void rounds(FieldProblem& field, int first, int last, Outcome& outcome)
    {
        for (int k = first; k < last && !outOfTime(field); ++k)
        {
            projectionRound(field, _weights);
            if (k >= _tuning.roundsBeforeWeights) reweigh(field, _weights, _tuning.mostReweighing);
            ++outcome.iterations;
        }
    }

    // Tries several sets of starting phases and continues with the loudest (SOLVER.md, "Cold
    // start"): the phases decide the level, while corrections remove the error from any of them.
    void coldStart(FieldProblem& field, int limit, Outcome& outcome)
    {
        const auto n = static_cast<std::size_t>(field.n());
        std::mt19937_64 random(options().seed);
        copy(field.u, _startU, n);
        const int trial = std::min(_tuning.trialRounds, limit);
        constexpr auto kFullTurn_rad = static_cast<float>(base::kTwoPi);
        float best = -1.0f;
        for (int start = 0; start < (limit > _tuning.trialRounds ? _tuning.coldStarts : 1) &&
                            (start == 0 || !outOfTime(field));
             ++start)
        {
            for (std::size_t l = 0; l < n; ++l)
            {
                const float turn = kFullTurn_rad * static_cast<float>(random() >> 40) * 0x1p-24f;
                field.u.set(l, start == 0 ? _startU.at(l) : std::polar(1.0f, turn));
            }
            _weights = field.a;
            rounds(field, 0, trial, outcome);
            const float level = naturalLevel(field);
            if (level <= best) continue;
            best = level;
            _bestWeights = _weights;
            copy(field.u, _bestU, n);
        }
        _weights = _bestWeights;
        copy(_bestU, field.u, n);
        rounds(field, trial, std::min(_tuning.coldRounds, limit), outcome);
    }

    // Chooses amplitudes that the device can play and scales field.q and y by them (SOLVER.md,
    // "Amplitudes"). \a full is the level of unit amplitudes.
    void chooseAmplitudes(FieldProblem& field, float full)
    {
        auto share = static_cast<float>(options().loudness);
        if (isAbsolute() && full > 0.0f) share = std::min(share, largestTarget() / full);
        const std::vector<float>& levels = field.drive().amplitudeLevels;
        _uniform = options().phaseOnly && !isAbsolute();
        if (options().phaseOnly)
        {
            const float nearest = playableAmplitude(levels, share);
            _full = _uniform && nearest == 1.0f;
            if (_full) return;
            _gain = std::clamp(_uniform ? nearest : share, 0.0f, 1.0f);
            setAmplitudes(field);
            field.y *= _gain;
            kernels::scaleBy(field.G.paddedTransducers(),
                             _amplitudes.data(),
                             field.q.re.data(),
                             field.q.im.data());
            return;
        }
        _full = false;
        shapeAmplitudes(field, share);
    }

    // Sets the amplitudes that the device can play and that are nearest to _gain: phase-only, an
    // even mix of the two levels around it; else for each transducer the level nearest to
    // _gain |z_i|.
    void setAmplitudes(const FieldProblem& field)
    {
        const std::vector<float>& levels = field.drive().amplitudeLevels;
        if (options().phaseOnly) return mixAmplitudes(levels, _gain, field.m(), _amplitudes.data());
        for (std::size_t i = 0; i < static_cast<std::size_t>(field.m()); ++i)
            _amplitudes[i] = playableAmplitude(levels, _gain * std::abs(field.z.at(i)));
    }

    // The corrections have changed the level. One factor on all amplitudes moves it back to the
    // targets, as far as the array is loud enough.
    void settleLevel(FieldProblem& field)
    {
        const float enough = 1.0f / static_cast<float>(field.m());
        for (int pass = 0; pass < _tuning.settlePasses; ++pass)
        {
            const float ratio = largestTarget() / fittedLevel(field);
            const bool isFull = options().phaseOnly && _gain >= 1.0f && ratio > 1.0f;
            if (isFull || !std::isfinite(ratio) || std::fabs(ratio - 1.0f) < enough) return;
            _gain *= ratio;
            setAmplitudes(field);
            play(field, 0.0f, true);
            field.clearPadding(field.q);
        }
    }

    // Sets |q_i| = min(1, g |z_i|), which takes the least power for a field; g is fitted to the
    // level asked for.
    void shapeAmplitudes(FieldProblem& field, float share)
    {
        double power = 0.0;
        for (int i = 0; i < field.m(); ++i)
            power += std::norm(field.z.at(static_cast<std::size_t>(i)));
        const auto rms = static_cast<float>(std::sqrt(power / field.m()));
        _gain = rms > 0.0f ? share / rms : 0.0f;
        copy(field.q, _continuous, lanes(field));
        for (int pass = 0; pass < _tuning.shapePasses; ++pass)
        {
            setAmplitudes(field);
            for (std::size_t i = 0; i < static_cast<std::size_t>(field.m()); ++i)
                field.q.set(i, _continuous.at(i) * _amplitudes[i]);
            field.forward(field.q, field.p);
            field.phasesOf(field.p);
            if (!isAbsolute()) return;
            const float level = naturalLevel(field);
            if (level > 0.0f) _gain *= largestTarget() / level;
        }
    }

    // Takes \a fraction of the correction's step and measures the resulting field, with its phases
    // rounded to the device's levels if \a rounded.
    void play(FieldProblem& field, float fraction, bool rounded)
    {
        field.eachBlock([&](int thread) { field.clearPartial(thread); },
                        [&](int thread, int block)
                        {
                            if (fraction > 0.0f)
                                _correction.turn(field, block, fraction, _continuous);
                            if (rounded) roundBlock(field, block);
                            field.forwardBlock(thread, block, rounded ? field.q : _continuous);
                        });
        field.sumPartials(field.p);
        field.phasesOf(field.p);
    }

    void roundBlock(FieldProblem& field, int block)
    {
        const int i = field.G.offset(block), width = field.G.width(block);
        float *re = field.q.re.data() + i, *im = field.q.im.data() + i;
        kernels::quantisePhase(width,
                               field.drive().phaseLevels,
                               _continuous.re.data() + i,
                               _continuous.im.data() + i,
                               re,
                               im);
        if (!_full) kernels::scaleBy(width, _amplitudes.data() + i, re, im);
    }

    // Takes the largest of stepFractions that lowers the error: far from a solution, or with
    // crowded points, |p| is not linear over the whole step. Returns the fraction taken; 0: none
    // lowers it, and _continuous is unchanged.
    float stepCarefully(FieldProblem& field, float error)
    {
        copy(_continuous, _before, lanes(field));
        for (const float fraction : _tuning.stepFractions)
        {
            play(field, fraction, false);
            if (errorOf(field, naturalLevel(field)) < error) return fraction;
            copy(_before, _continuous, lanes(field));
        }
        return 0.0f;
    }

    // Makes a round of projections in place of a correction that did not lower the error; a round
    // needs no linearisation.
    void roundInstead(FieldProblem& field)
    {
        field.forward(_continuous, field.p);
        field.phasesOf(field.p);
        reweigh(field, _weights, _tuning.mostReweighing);
        projectionRound(field, _weights);
        copy(field.q, _continuous, lanes(field));
    }

    static std::size_t lanes(const FieldProblem& field)
    {
        return static_cast<std::size_t>(field.G.paddedTransducers());
    }
    static void copy(const SplitVector& from, SplitVector& to, std::size_t count)
    {
        std::copy_n(from.re.data(), count, to.re.data());
        std::copy_n(from.im.data(), count, to.im.data());
    }

    // Returns the CG tolerance (SOLVER.md, "CG tolerance"): nextTolerance times the error before
    // the next correction, or farTolerance times the present error where the linearisation does not
    // hold, since late CG steps follow ill-conditioned directions. Never below \a least, which
    // rounding or the options' tolerance determine.
    float toleranceOf(float error, float nextError, float least) const
    {
        return std::max(least,
                        error > _tuning.searchAbove ? _tuning.farTolerance * error
                                                    : _tuning.nextTolerance * nextError);
    }

    // Corrects until the played field is as exact as was asked for or its error is all rounding. A
    // correction leaves about the square of the rms error before it. If that is still too much,
    // another correction follows, so CG stops early and the phases are not rounded.
    void correct(FieldProblem& field, int limit, Outcome& outcome)
    {
        const auto tolerance = static_cast<float>(options().rmsTolerance);
        outcome.stop = StopReason::MAX_ITERATIONS;
        std::swap(_continuous, field.q);
        for (int k = 0; k < _tuning.corrections; ++k)
        {
            const float rounding = roundingError(field);
            const float enough = std::max(tolerance, _tuning.roundingMargin * rounding);
            const float error = errorOf(field, naturalLevel(field));
            const float least = _tuning.lastTolerance * std::max(rounding, tolerance);
            const bool out =
                k + 1 == _tuning.corrections || outcome.iterations + 1 >= limit || outOfTime(field);
            const bool last = out || error * error < enough;
            _correction.solve(field,
                              _continuous,
                              _weights,
                              toleranceOf(error, last ? 0.0f : error * error, least),
                              _tuning.conjugateSteps);
            ++outcome.iterations;
            float fraction = 1.0f;
            if (error > _tuning.searchAbove)
            {
                fraction = stepCarefully(field, error);
                if (fraction == 0.0f && !out)
                {
                    roundInstead(field);
                    continue;
                }
                if (last) play(field, 0.0f, true);
            }
            else
                play(field, 1.0f, last);
            for (int l = 0; l < field.n(); ++l)
                _weights[l] = std::max(_weights[l] + fraction * _correction.multiplier(l),
                                       _tuning.leastOfWeight * _weights[l]);
            if (!last) continue;
            const float rms = errorOf(field, fittedLevel(field));
            if (rms <= tolerance)
                outcome.stop = StopReason::CONVERGED;
            else if (rms < _tuning.roundingMargin * rounding)
                outcome.stop = StopReason::STALLED;
            else if (outOfTime(field))
                outcome.stop = StopReason::DEADLINE;
            if (out || outcome.stop != StopReason::MAX_ITERATIONS) break;
            field.forward(_continuous, field.p);
            field.phasesOf(field.p);
        }
        field.clearPadding(field.q);
    }

    GaussNewtonTuning _tuning;
    GaussNewtonStep _correction;
    SplitVector _startU, _bestU;            // n
    SplitVector _continuous, _before;       // m, q before rounding; the same before a correction
    base::AlignedBuffer<float> _amplitudes; // m
    Eigen::VectorXf _weights, _bestWeights;
    float _loudest = 0.0f;   // largest recent loudness, times forget per update since
    float _gain = 1.0f;      // phase-only: the mean amplitude; else the factor on |z_i|
    int _weightsOf = 0;      // number of points that the weights belong to
    bool _projected = false; // build() has made the first round
    bool _uniform = true;    // all transducers play one amplitude
    bool _full = true;       // all transducers play amplitude 1
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
