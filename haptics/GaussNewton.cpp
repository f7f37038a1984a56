#include "haptics/PhaseCorrection.h"
#include "haptics/SolverBase.h"
#include "haptics/Solvers.h"

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
constexpr int kCorrections = 8;
constexpr int kConjugateSteps = 12;

/// The production solver: alternating projections to a good set of phases, then Gauss-Newton in the points' weights.
/// Every field is q = z/|z|, z = G* c with c_l = w_l u_l, u_l the phase of p_l: that is what being as loud as possible with
/// equal relative errors asks for (the multipliers of |p_l| = s a_l under |q_i| <= 1 are the weights w). An update takes the
/// weights and phases of the last field to the new matrix (one round), and corrects (PhaseCorrection), which moves
/// the weights along; a cold start finds them by rounds of w_l <- w_l s a_l/|p_l|, u_l <- phase of p_l.
class GaussNewton final : public SolverBase
{
public:
    explicit GaussNewton(const SolverOptions& options) : SolverBase("gauss-newton", options) {}

private:
    Outcome iterate(FieldProblem& field, bool warm) override
    {
        reserve(field);
        Outcome outcome;
        const int limit = iterationLimit(1000);
        if (!warm || _weightsOf != field.n())
            coldStart(field, std::max(1, limit - kCorrections), outcome);
        _weightsOf = field.n();
        projectionRound(field);
        ++outcome.iterations;
        alignToLast(field);
        const float full = naturalLevel(field);
        chooseAmplitudes(field, full);
        if (isLimited())
        {
            limitSteps();
            field.forward(field.q, field.p);
            field.phasesOf(field.p);
        }
        correct(field, limit, outcome);
        const float mean = _weights.mean();
        _weights /= mean;
        outcome.playable = outcome.measured = !isLimited();
        return outcome;
    }

    void reserve(const FieldProblem& field)
    {
        const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
        const auto n = static_cast<std::size_t>(field.n());
        for (SplitVector* v : {&_c, &_startU, &_bestU})
            v->reserve(n);
        _continuous.reserve(m);
        _amplitudes.reserve(m);
        for (Eigen::VectorXf* v : {&_weights, &_bestWeights})
            if (v->size() != field.n()) v->resize(field.n());
    }

    void projectionRound(FieldProblem& field)
    {
        for (int l = 0; l < field.n(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            _c.set(row, field.u.at(row) * _weights[l]);
        }
        field.projectRound(_c, field.p);
        field.phasesOf(field.p);
    }

    // s with sum_l w_l (s a_l - |p_l|) = 0: no change of the phases of q alters sum_l w_l |p_l| to first order, so that any
    // other level is out of a correction's reach.
    float naturalLevel(const FieldProblem& field) const
    {
        return _weights.dot(field.y) / _weights.dot(field.a);
    }

    static float errorOf(const FieldProblem& field, float s)
    {
        const auto error = field.y.array() / (s * field.a.array()) - 1.0f;
        return std::sqrt(error.square().mean());
    }
    static float fittedLevel(const FieldProblem& field)
    {
        return field.y.dot(field.a) / field.a.squaredNorm();
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
        if (options().absoluteTargets && full > 0.0f)
            share = std::min(share, largestTarget() / full);
        const std::vector<float>& levels = field.drive().amplitudeLevels;
        _uniform = options().phaseOnly && !options().absoluteTargets;
        if (options().phaseOnly)
        {
            const float nearest = playableAmplitude(levels, share);
            _full = _uniform && nearest == 1.0f;
            if (_full) return;
            mixLevels(levels, _uniform ? nearest : share, field.m());
            const float mean = _uniform ? nearest : std::clamp(share, 0.0f, 1.0f);
            field.y *= mean;
            kernels::scaleBy(field.G.paddedTransducers(),
                             _amplitudes.data(),
                             field.q.re.data(),
                             field.q.im.data());
            return;
        }
        _full = false;
        shapeAmplitudes(field, share);
    }

    // Between two levels of the device: some transducers at the one, some at the other, evenly spread.
    void mixLevels(const std::vector<float>& levels, float mean, int m)
    {
        const float wanted = std::clamp(mean, 0.0f, 1.0f);
        float low = wanted, high = wanted;
        if (!levels.empty())
        {
            const auto above = std::lower_bound(levels.begin(), levels.end(), wanted);
            high = above == levels.end() ? levels.back() : *above;
            low = above == levels.begin() || high == wanted ? high : *(above - 1);
        }
        const float share = high > low ? (wanted - low) / (high - low) : 1.0f;
        float owed = 0.5f;
        for (int i = 0; i < m; ++i)
        {
            owed += share;
            const bool isHigh = owed >= 1.0f;
            owed -= isHigh ? 1.0f : 0.0f;
            _amplitudes[static_cast<std::size_t>(i)] = isHigh ? high : low;
        }
    }

    // |q_i| = min(1, g |z_i|): the least power for what is asked, and what is asked decides g.
    void shapeAmplitudes(FieldProblem& field, float share)
    {
        double power = 0.0;
        for (int i = 0; i < field.m(); ++i)
            power += std::norm(field.z.at(static_cast<std::size_t>(i)));
        const auto rms = static_cast<float>(std::sqrt(power / field.m()));
        float g = rms > 0.0f ? share / rms : 0.0f;
        std::copy_n(field.q.re.data(), field.G.paddedTransducers(), _continuous.re.data());
        std::copy_n(field.q.im.data(), field.G.paddedTransducers(), _continuous.im.data());
        for (int pass = 0; pass < 3; ++pass)
        {
            for (int i = 0; i < field.m(); ++i)
            {
                const auto s = static_cast<std::size_t>(i);
                _amplitudes[s] =
                    playableAmplitude(field.drive().amplitudeLevels, g * std::abs(field.z.at(s)));
                field.q.set(s, _continuous.at(s) * _amplitudes[s]);
            }
            field.forward(field.q, field.p);
            field.phasesOf(field.p);
            if (!options().absoluteTargets) return;
            const float level = naturalLevel(field);
            if (level > 0.0f) g *= largestTarget() / level;
        }
    }

    // Rounds field.q's phases to the device's levels and measures that field: its rms error.
    float play(FieldProblem& field)
    {
        std::swap(_continuous, field.q);
        field.quantisePhases(_continuous, field.q);
        if (!_full)
            kernels::scaleBy(field.G.paddedTransducers(),
                             _amplitudes.data(),
                             field.q.re.data(),
                             field.q.im.data());
        field.forward(field.q, field.p);
        field.phasesOf(field.p);
        return errorOf(field, fittedLevel(field));
    }

    // Corrections until the played field is as exact as was asked for, or its error is all rounding.
    void correct(FieldProblem& field, int limit, Outcome& outcome)
    {
        const auto tolerance = static_cast<float>(options().rmsTolerance);
        const float steps = static_cast<float>(std::max(field.drive().phaseLevels, 2));
        outcome.stop = StopReason::MAX_ITERATIONS;
        for (int k = 0; k < kCorrections; ++k)
        {
            const float loudness =
                fittedLevel(field) * field.a.norm() / static_cast<float>(field.meanRowSum());
            // Phases off by up to pi/levels: rms pi/(sqrt 3 levels), spread over m transducers (0.0071 for 256 levels).
            const float rounding = field.drive().phaseLevels == 0
                                       ? 0.0f
                                       : 1.814f / steps *
                                             std::sqrt(static_cast<float>(field.n()) / field.m()) /
                                             std::max(loudness, 0.05f);
            const float goal = std::max(0.45f * rounding, 0.45f * tolerance);
            _correction.solve(field, naturalLevel(field), goal, kConjugateSteps, true);
            for (int l = 0; l < field.n(); ++l)
                _weights[l] =
                    std::max(_weights[l] + _correction.multiplier(l), 0.02f * _weights[l]);
            ++outcome.iterations;
            const float rms = play(field);
            if (rms <= tolerance)
                outcome.stop = StopReason::CONVERGED;
            else if (rms * rms < 1.7f * rounding * rounding)
                outcome.stop = StopReason::STALLED;
            else if (outOfTime(field))
                outcome.stop = StopReason::DEADLINE;
            if (outcome.stop != StopReason::MAX_ITERATIONS || outcome.iterations >= limit ||
                k + 1 == kCorrections)
                return;
            std::swap(_continuous, field.q);
            field.forward(field.q, field.p);
            field.phasesOf(field.p);
        }
    }

    PhaseCorrection _correction;
    SplitVector _c, _startU, _bestU;  // n
    SplitVector _continuous;          // m: q before its phases were rounded
    AlignedBuffer<float> _amplitudes; // m
    Eigen::VectorXf _weights, _bestWeights;
    int _weightsOf = 0;   // n of the field whose weights these are
    bool _uniform = true; // one amplitude for all
    bool _full = true;    // and that 1
};

} // namespace

std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options)
{
    return std::make_unique<GaussNewton>(options);
}

} // namespace midair::haptics
