#include "haptics/solvers/FieldFigures.h"
#include "haptics/solvers/GaussNewtonStep.h"
#include "haptics/solvers/SolverBase.h"
#include "haptics/solvers/Solvers.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace midair::haptics
{

namespace
{

constexpr int kColdStarts = 3;
constexpr int kTrialRounds = 10; // of each start
constexpr int kColdRounds = 30;  // of the best, those of its trial among them
constexpr int kRoundsBeforeWeights = 3;
constexpr int kRoundsWhenQuiet = 2;
constexpr float kQuiet = 0.996f;   // of the loudness lately
constexpr float kForget = 0.9998f; // an update
constexpr int kCorrections = 8;
constexpr int kConjugateSteps = 12;
constexpr float kTrusted =
    0.1f; // errors up to which a correction is not looked at before it is taken

/// The production solver: alternating projections to a good set of phases, then Gauss-Newton in the points' weights.
/// Every field is q = z/|z|, z = G* c with c_l = w_l u_l, u_l the phase of p_l: that is what being as loud as possible with
/// equal relative errors asks for (the multipliers of |p_l| = s a_l under |q_i| <= 1 are the weights w). An update takes the
/// weights and phases of the last field to the new matrix (one round), and corrects (GaussNewtonStep), which moves
/// the weights along; a cold start finds them by rounds of w_l <- w_l s a_l/|p_l|, u_l <- phase of p_l.
class GaussNewton final : public SolverBase
{
public:
    explicit GaussNewton(const SolverOptions& options) :
        SolverBase("gauss-newton", options, Storage::FIXED)
    {
    }

private:
    Outcome iterate(FieldProblem& field, bool warm) override
    {
        reserve(field);
        Outcome outcome;
        const int limit = iterationLimit(1000);
        _projected = _projected && warm;
        if (!warm || _weightsOf != field.n())
        {
            coldStart(field, std::max(1, limit - kCorrections), outcome);
            _loudest = loudnessAt(field, naturalLevel(field));
        }
        _weightsOf = field.n();
        if (!_projected) projectionRound(field);
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
        weighPhases(field);
        field.buildAndProject(_c, field.p);
        field.phasesOf(field.p);
    }

    void reserve(const FieldProblem& field)
    {
        const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
        const auto n = static_cast<std::size_t>(field.n());
        for (SplitVector* v : {&_c, &_startU, &_bestU})
            v->reserve(n);
        _continuous.reserve(m);
        _before.reserve(m);
        _amplitudes.reserve(m);
        for (Eigen::VectorXf* v : {&_weights, &_bestWeights})
            if (v->size() != field.n()) v->resize(field.n());
    }

    void weighPhases(const FieldProblem& field)
    {
        for (int l = 0; l < field.n(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            _c.set(row, field.u.at(row) * _weights[l]);
        }
    }

    void projectionRound(FieldProblem& field)
    {
        weighPhases(field);
        field.projectRound(_c, field.p);
        field.phasesOf(field.p);
    }

    // s with sum_l w_l (s a_l - |p_l|) = 0: no change of the phases of q alters sum_l w_l |p_l| to first order, so that any
    // other level is out of a correction's reach.
    float naturalLevel(const FieldProblem& field) const
    {
        return _weights.dot(field.y) / _weights.dot(field.a);
    }

    // Phases that follow a moving object come to be at home in a poorer place than they set out from: further rounds, where
    // the field is quieter than it lately was.
    void keepLoud(FieldProblem& field, int limit, Outcome& outcome)
    {
        for (int k = 0;
             k < kRoundsWhenQuiet && loudnessAt(field, naturalLevel(field)) < kQuiet * _loudest &&
             outcome.iterations + 2 < limit && !outOfTime(field);
             ++k)
        {
            reweigh(field);
            projectionRound(field);
            ++outcome.iterations;
        }
        _loudest = std::max(kForget * _loudest, loudnessAt(field, naturalLevel(field)));
    }

    void reweigh(const FieldProblem& field)
    {
        const float s = fittedLevel(field);
        for (int l = 0; l < field.n(); ++l)
            _weights[l] *= std::clamp(s * field.a[l] / std::max(field.y[l], 1e-30f), 0.2f, 5.0f);
    }

    void rounds(FieldProblem& field, int first, int last, Outcome& outcome)
    {
        for (int k = first; k < last && !outOfTime(field); ++k)
        {
            projectionRound(field);
            if (k >= kRoundsBeforeWeights) reweigh(field);
            ++outcome.iterations;
        }
    }

    // Several starts, the loudest of which goes on: where the phases settle decides the level, not the error.
    void coldStart(FieldProblem& field, int limit, Outcome& outcome)
    {
        const auto n = static_cast<std::size_t>(field.n());
        std::mt19937_64 random(options().seed);
        std::copy_n(field.u.re.data(), n, _startU.re.data());
        std::copy_n(field.u.im.data(), n, _startU.im.data());
        const int trial = std::min(kTrialRounds, limit);
        float best = -1.0f;
        for (int start = 0;
             start < (limit > kTrialRounds ? kColdStarts : 1) && (start == 0 || !outOfTime(field));
             ++start)
        {
            for (std::size_t l = 0; l < n; ++l)
            {
                const float turn = 6.2831853f * static_cast<float>(random() >> 40) * 0x1p-24f;
                field.u.set(l, start == 0 ? _startU.at(l) : std::polar(1.0f, turn));
            }
            _weights = field.a;
            rounds(field, 0, trial, outcome);
            const float level = naturalLevel(field);
            if (level <= best) continue;
            best = level;
            _bestWeights = _weights;
            std::copy_n(field.u.re.data(), n, _bestU.re.data());
            std::copy_n(field.u.im.data(), n, _bestU.im.data());
        }
        _weights = _bestWeights;
        std::copy_n(_bestU.re.data(), n, field.u.re.data());
        std::copy_n(_bestU.im.data(), n, field.u.im.data());
        rounds(field, trial, std::min(kColdRounds, limit), outcome);
    }

    // Amplitudes the device can play, and field.q, y with them. \a full is the level of unit amplitudes.
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

    // What the device can play of _gain: evenly mixed levels with phases alone, else levels next to _gain |z_i|.
    void setAmplitudes(const FieldProblem& field)
    {
        const std::vector<float>& levels = field.drive().amplitudeLevels;
        if (options().phaseOnly) return mixAmplitudes(levels, _gain, field.m(), _amplitudes.data());
        for (std::size_t i = 0; i < static_cast<std::size_t>(field.m()); ++i)
            _amplitudes[i] = playableAmplitude(levels, _gain * std::abs(field.z.at(i)));
    }

    // The corrections moved the level: all amplitudes by one factor move it back, as far as the array reaches.
    void settleLevel(FieldProblem& field)
    {
        const float enough = 1.0f / static_cast<float>(field.m());
        for (int pass = 0; pass < 4; ++pass)
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

    // |q_i| = min(1, g |z_i|): the least power for what is asked, and what is asked decides g.
    void shapeAmplitudes(FieldProblem& field, float share)
    {
        double power = 0.0;
        for (int i = 0; i < field.m(); ++i)
            power += std::norm(field.z.at(static_cast<std::size_t>(i)));
        const auto rms = static_cast<float>(std::sqrt(power / field.m()));
        _gain = rms > 0.0f ? share / rms : 0.0f;
        std::copy_n(field.q.re.data(), field.G.paddedTransducers(), _continuous.re.data());
        std::copy_n(field.q.im.data(), field.G.paddedTransducers(), _continuous.im.data());
        for (int pass = 0; pass < 3; ++pass)
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

    // Takes \a fraction of the correction's step and measures the field of it, its phases rounded to the device's levels if
    // \a rounded.
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

    // The correction's step, or as much of it as makes the field better: far from a solution (crowded points) its straight
    // line misleads. Returns the fraction taken; 0: none helped.
    float stepCarefully(FieldProblem& field, float error)
    {
        copy(field, _continuous, _before);
        for (const float fraction : {1.0f, 0.3f, 0.1f})
        {
            play(field, fraction, false);
            if (errorOf(field, naturalLevel(field)) < error) return fraction;
            copy(field, _before, _continuous);
        }
        return 0.0f;
    }

    // Where no correction helps: a round of projections, which gets nearer however far it is.
    void roundInstead(FieldProblem& field)
    {
        field.forward(_continuous, field.p);
        field.phasesOf(field.p);
        reweigh(field);
        projectionRound(field);
        copy(field, field.q, _continuous);
    }

    static void copy(const FieldProblem& field, const SplitVector& from, SplitVector& to)
    {
        const int m = field.G.paddedTransducers();
        std::copy_n(from.re.data(), m, to.re.data());
        std::copy_n(from.im.data(), m, to.im.data());
    }

    // How far a correction is driven: no further than the next one will start from, nor, far from a solution, along the
    // directions in which little can be had (which is what the first steps leave out).
    static float goalOf(float error, float nextError, float goal)
    {
        return std::max(goal, error > kTrusted ? 0.5f * error : 0.4f * nextError);
    }

    // Corrections until the played field is as exact as was asked for, or its error is all rounding. A correction is exact
    // to the square of what it corrects: where that is too much, it is not driven further than that, nor its phases
    // rounded, since another one follows.
    void correct(FieldProblem& field, int limit, Outcome& outcome)
    {
        const auto tolerance = static_cast<float>(options().rmsTolerance);
        outcome.stop = StopReason::MAX_ITERATIONS;
        std::swap(_continuous, field.q);
        for (int k = 0; k < kCorrections; ++k)
        {
            const float rounding = roundingError(field);
            const float enough = std::max(tolerance, 1.3f * rounding);
            const float error = errorOf(field, naturalLevel(field));
            const float goal = 0.45f * std::max(rounding, tolerance);
            const bool out =
                k + 1 == kCorrections || outcome.iterations + 1 >= limit || outOfTime(field);
            const bool last = out || error * error < enough;
            _correction.solve(field,
                              _continuous,
                              _weights,
                              goalOf(error, last ? 0.0f : error * error, goal),
                              kConjugateSteps);
            ++outcome.iterations;
            float fraction = 1.0f;
            if (error > kTrusted)
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
                                       0.02f * _weights[l]);
            if (!last) continue;
            const float rms = errorOf(field, fittedLevel(field));
            if (rms <= tolerance)
                outcome.stop = StopReason::CONVERGED;
            else if (rms < 1.3f * rounding)
                outcome.stop = StopReason::STALLED;
            else if (outOfTime(field))
                outcome.stop = StopReason::DEADLINE;
            if (out || outcome.stop != StopReason::MAX_ITERATIONS) break;
            field.forward(_continuous, field.p);
            field.phasesOf(field.p);
        }
        field.clearPadding(field.q);
    }

    GaussNewtonStep _correction;
    SplitVector _c, _startU, _bestU;  // n
    SplitVector _continuous, _before; // m: q before its phases were rounded, before a correction
    base::AlignedBuffer<float> _amplitudes; // m
    Eigen::VectorXf _weights, _bestWeights;
    float _loudest = 0.0f;   // lately
    float _gain = 1.0f;      // amplitudes: the mean of them, or what |z_i| is multiplied by
    int _weightsOf = 0;      // n of the field whose weights these are
    bool _projected = false; // build() took the first round
    bool _uniform = true;    // one amplitude for all
    bool _full = true;       // and that 1
};

} // namespace

std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options)
{
    return std::make_unique<GaussNewton>(options);
}

} // namespace midair::haptics
