#include "haptics/solvers/production/CrowdedDescent.h"

#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "Crowded points": damping of the steps, and their CG tolerance over the error.
constexpr float kCrowdedFirstDamping = 1.0f;
constexpr float kCrowdedLeastDamping = 1e-6f;
constexpr float kCrowdedMostDamping = 1e4f;
constexpr float kAfterFailure = 4.0f;
constexpr float kAfterSuccess = 0.3f;
constexpr float kCrowdedInnerTolerance = 0.1f;

// Returns the level that minimises f; with quiet points, some of which may be far too loud, the
// fitted one.
float bestLevel(const FieldProblem& field, const QuietPoints& quiet)
{
    if (quiet.any()) return fittedLevel(field);
    const auto squares = (field.y.array() / field.a.array()).square();
    return std::sqrt(squares.square().sum() / squares.sum());
}

float errorAt(const FieldProblem& field, const QuietPoints& quiet, float level)
{
    const auto shares = (field.y.array() / (level * field.a.array())).square();
    if (!quiet.any()) return 0.5f * std::sqrt((1.0f - shares).square().mean());
    const auto counts = (field.a.array() / QuietPoints::kQuiet).min(1.0f);
    return 0.5f * std::sqrt((counts * (1.0f - shares)).square().mean());
}

float fittedError(const FieldProblem& field, const QuietPoints& quiet)
{
    return quiet.error(field, fittedLevel(field));
}

// Returns the phase of one transducer's wave at one point.
std::complex<float> arriving(const FieldProblem& field, int point, int lane)
{
    const std::complex<float> entry = field.G.at(point, lane);
    const float size = std::abs(entry);
    return size > kLeastPressure ? entry / size : 1.0f;
}

// Sets the phases u to those of one transducer's wave.
void arriveFrom(FieldProblem& field, int lane)
{
    for (int l = 0; l < field.n(); ++l)
        field.u.set(static_cast<std::size_t>(l), arriving(field, l, lane));
}

// Returns transducer \a k of \a count, evenly spread.
int startLane(const FieldProblem& field, int k, int count)
{
    return (2 * k + 1) * field.m() / (2 * count);
}

} // namespace

void DriveAmplitudes::choose(FieldProblem& field, const Wish& wish, float full)
{
    _wish = wish;
    const bool absolute = wish.level_Pa > 0.0f;
    float share = wish.loudness;
    if (absolute && full > 0.0f) share = std::min(share, wish.level_Pa / full);
    if (wish.phaseOnly && !absolute)
        share = playableAmplitude(field.drive().amplitudeLevels, share);
    _full = wish.phaseOnly && !absolute && share == 1.0f;
    if (_full) return;
    _gain = std::clamp(share, 0.0f, 1.0f);
    if (!wish.phaseOnly)
    {
        double power = 0.0;
        for (int i = 0; i < field.m(); ++i)
            power += std::norm(field.z.at(static_cast<std::size_t>(i)));
        const auto rms = static_cast<float>(std::sqrt(power / field.m()));
        _gain = rms > 0.0f ? share / rms : 0.0f;
    }
    set(field);
}

// Sets the playable amplitudes nearest to _gain: phase-only, an even mix of the two levels around
// it; otherwise for each transducer the level nearest to _gain |z_i|. Targets in Pa use at least
// one transducer.
void DriveAmplitudes::set(const FieldProblem& field)
{
    const std::vector<float>& levels = field.drive().amplitudeLevels;
    if (_wish.phaseOnly)
        mixAmplitudes(levels, _gain, field.m(), _amplitudes.data());
    else
    {
        for (std::size_t i = 0; i < static_cast<std::size_t>(field.m()); ++i)
            _amplitudes[i] = std::clamp(_gain * std::abs(field.z.at(i)), 0.0f, 1.0f);
        roundAmplitudes(levels,
                        field.m(),
                        _amplitudes.data(),
                        _wish.level_Pa > 0.0f ? kCoarseTarget : kCoarseSum);
    }
    measure(field);
    if (!(_wish.level_Pa > 0.0f) || !(_gain > 0.0f) || _rms > 0.0f) return;
    const auto least = std::upper_bound(levels.begin(), levels.end(), 0.0f);
    const auto first = static_cast<std::size_t>(evenOrder(field.m()).front());
    _amplitudes[first] = least == levels.end() ? _gain : *least;
    measure(field);
}

void DriveAmplitudes::measure(const FieldProblem& field)
{
    const Eigen::Map<const Eigen::VectorXf> all(_amplitudes.data(), field.m());
    _rms = static_cast<float>(std::sqrt(all.cast<double>().squaredNorm() / field.m()));
}

// A level between two device levels is a mix of both, so one transducer's step between them is the
// smallest change of the sum of all amplitudes.
float DriveAmplitudes::leastChange(const FieldProblem& field) const
{
    const std::vector<float>& levels = field.drive().amplitudeLevels;
    const float mean = rms();
    const auto above = std::lower_bound(levels.begin(), levels.end(), mean);
    if (above == levels.end() || !(mean > 0.0f)) return 0.0f;
    const float below = above == levels.begin() ? 0.0f : *(above - 1);
    return (*above - below) / (static_cast<float>(field.m()) * mean);
}

bool DriveAmplitudes::scale(const FieldProblem& field, float ratio)
{
    if (!(ratio > 0.0f) || !std::isfinite(ratio) ||
        std::fabs(ratio - 1.0f) <= 0.5f * leastChange(field) || (isFull() && ratio > 1.0f))
        return false;
    _gain = _wish.phaseOnly ? std::min(_gain * ratio, 1.0f) : _gain * ratio;
    set(field);
    return true;
}

void CorrectedDrive::begin(const FieldProblem& field)
{
    const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
    _phases.reserve(m);
    amplitudes.reserve(field);
    copy(field.q, _phases, m);
}

// Sets q in one block; with an effort, rounds all transducers except those to be shaped.
void CorrectedDrive::put(FieldProblem& field, int block, const ShapedRounding::Effort* effort)
{
    const int lane = field.G.offset(block), width = field.G.width(block);
    const float *fromRe = _phases.re.data() + lane, *fromIm = _phases.im.data() + lane;
    float *re = field.q.re.data() + lane, *im = field.q.im.data() + lane;
    const int rounded = effort ? ShapedRounding::first(field, block, *effort) : 0;
    kernels::quantisePhase(rounded, field.drive().phaseLevels, fromRe, fromIm, re, im);
    std::copy(fromRe + rounded, fromRe + width, re + rounded);
    std::copy(fromIm + rounded, fromIm + width, im + rounded);
    if (amplitudes.data()) kernels::scaleBy(width, amplitudes.data() + lane, re, im);
}

void CorrectedDrive::advance(FieldProblem& field,
                             const GaussNewtonStep* step,
                             const ShapedRounding::Effort* effort,
                             const QuietPoints* quiet)
{
    const bool continuous = field.drive().phaseLevels == 0;
    if (continuous) effort = nullptr;
    field.eachBlock(
        [&](int, int block)
        {
            if (step) step->turn(field, block, _phases);
            put(field, block, effort);
            field.forwardBlock(block, field.q);
        });
    field.sumPartials(field.p);
    field.phasesOf(field.p);
    if (effort && effort->share > 0.0f)
        _shaping.shape(field, *quiet, amplitudes.data(), fittedLevel(field), *effort);
    if (effort || continuous) field.clearPadding(field.q);
}

int CrowdedDescent::descend(FieldProblem& field,
                            const QuietPoints& quiet,
                            CorrectedDrive& drive,
                            GaussNewtonStep& step,
                            Pace& pace,
                            const Wish& wish,
                            const Begin& begin)
{
    Work work{field, quiet, drive, step, pace, wish, begin};
    _beganAnew = !takeKept(work);
    if (field.G.hasOutside())
    {
        work.level = bestLevel(field, work.quiet);
        fit(work, _tuning.coldDamped, _tuning.leastCold * work.level);
    }
    else if (!_beganAnew)
    {
        work.level = _tuning.recovery * bestLevel(field, work.quiet);
        fit(work, _tuning.damped, _tuning.yield * work.level);
    }
    else
        beginAnew(work);
    keep(work);
    return work.steps;
}

// Takes the phases of the last descent if their error is smaller than the projection's and they did
// not become much quieter. They are moved with the points: a transducer whose wave now arrives
// later must begin earlier.
bool CrowdedDescent::takeKept(Work& work)
{
    FieldProblem& field = work.field;
    const int m = field.m();
    if (field.G.hasOutside())
    {
        // Outside pressures are true of their drive, so the nearest field that fits is the best.
        SplitVector& given = work.drive.phases();
        field.G.outsidePhases(given.re.data(), given.im.data());
        work.drive.measure(field);
        return true;
    }
    if (!_hasKept || _lanes != m) return false;
    const float projected = fittedError(field, work.quiet);
    const int point = field.n() / 2;
    for (int i = 0; work.wish.moved && i < m; ++i)
    {
        const auto lane = static_cast<std::size_t>(i);
        _kept.set(lane, _kept.at(lane) * _arrival.at(lane) * std::conj(arriving(field, point, i)));
    }
    SplitVector& phases = work.drive.phases();
    std::swap(phases.re, _kept.re);
    std::swap(phases.im, _kept.im);
    work.drive.measure(field);
    if (fittedError(field, work.quiet) < projected &&
        loudnessAt(field, fittedLevel(field)) > _tuning.leastKept * _loudness)
        return true;
    std::swap(phases.re, _kept.re);
    std::swap(phases.im, _kept.im);
    work.drive.measure(field);
    return false;
}

void CrowdedDescent::keep(const Work& work)
{
    const FieldProblem& field = work.field;
    const auto padded = static_cast<std::size_t>(field.G.paddedTransducers());
    _kept.reserve(padded);
    _arrival.reserve(padded);
    copy(work.drive.phases(), _kept, padded);
    for (int i = 0; i < field.m(); ++i)
        _arrival.set(static_cast<std::size_t>(i), arriving(field, field.n() / 2, i));
    _lanes = field.m();
    _hasKept = true;
}

bool CrowdedDescent::isOver(const Work& work) const
{
    work.field.stop().throwIfRequested();
    return work.steps >= work.wish.steps ||
           work.pace.fits(Pace::STEP, _tuning.dampedConjugateSteps) < _tuning.dampedConjugateSteps;
}

// Makes at most \a most damped steps. The level follows the field down to \a leastLevel.
void CrowdedDescent::fit(Work& work, int most, float leastLevel)
{
    FieldProblem& field = work.field;
    const auto padded = static_cast<std::size_t>(field.G.paddedTransducers());
    _before.reserve(padded);
    work.error = errorAt(field, work.quiet, work.level);
    float damping = kCrowdedFirstDamping;
    for (int k = 0; k < most && work.error > work.wish.goal && damping < kCrowdedMostDamping; ++k)
    {
        if (isOver(work)) return;
        const double start = field.elapsed_ms();
        const int made = work.step.solveDamped(field,
                                               field.q,
                                               work.quiet,
                                               work.level,
                                               kCrowdedInnerTolerance * work.error,
                                               _tuning.dampedConjugateSteps,
                                               damping);
        work.pace.took(Pace::STEP, made, field.elapsed_ms() - start);
        copy(work.drive.phases(), _before, padded);
        work.drive.turn(field, work.step);
        ++work.steps;
        if (errorAt(field, work.quiet, work.level) < work.error)
        {
            work.level = std::clamp(fittedLevel(field), leastLevel, work.level);
            work.error = errorAt(field, work.quiet, work.level);
            damping = std::max(kAfterSuccess * damping, kCrowdedLeastDamping);
            continue;
        }
        copy(_before, work.drive.phases(), padded);
        work.drive.measure(field);
        damping *= kAfterFailure;
    }
}

// A descent from the projection. If it ends with zeros between the points, another from the phases
// of the most power, then one from smooth phases; then more at lower levels while the error is not
// small. An error that reaches the goal is neither poor nor unfair: with few levels of phase the
// goal is above both.
void CrowdedDescent::beginAnew(Work& work)
{
    const float poor = std::max(_tuning.poor, work.wish.goal);
    work.level = bestLevel(work.field, work.quiet);
    fit(work, _tuning.coldDamped, _tuning.leastCold * work.level);
    if (work.error > poor && !isOver(work)) beginPowerfully(work);
    if (work.error > poor && !isOver(work)) beginSmoothly(work);
    for (int k = 0; k < _tuning.lowerings && work.error > fair(work) && !isOver(work); ++k)
    {
        work.level *= _tuning.lowering;
        fit(work, _tuning.coldDamped / 3, work.level);
    }
    raise(work);
    _loudness = loudnessAt(work.field, fittedLevel(work.field));
}

float CrowdedDescent::fair(const Work& work) const
{
    return std::max(_tuning.fair, work.wish.goal);
}

// Raises the level of a fitting field while it still fits; after a field that doesn't, by smaller
// factors.
void CrowdedDescent::raise(Work& work)
{
    FieldProblem& field = work.field;
    const auto padded = static_cast<std::size_t>(field.G.paddedTransducers());
    _quieter.reserve(padded);
    float factor = _tuning.raising;
    for (int k = 0;
         k < _tuning.raisings && factor > _tuning.leastRaising && work.error <= fair(work) &&
         loudnessAt(field, work.level) < _tuning.loud && !isOver(work);
         ++k)
    {
        const float level = work.level;
        copy(work.drive.phases(), _quieter, padded);
        work.level *= factor;
        fit(work, _tuning.coldDamped / 3, level);
        if (work.error <= fair(work)) continue;
        copy(_quieter, work.drive.phases(), padded);
        work.drive.measure(field);
        work.level = level;
        work.error = errorAt(field, work.quiet, level);
        factor = std::sqrt(factor);
    }
}

// Starts from phases u with a large power u* A K A u, A = diag(a): a zero of the field wastes
// power. The iteration u <- phase of K A u never lowers it. Of several starts the one of the most
// power is taken.
void CrowdedDescent::beginPowerfully(Work& work)
{
    FieldProblem& field = work.field;
    const auto n = static_cast<std::size_t>(field.n());
    _powerful.reserve(n);
    float most = 0.0f;
    for (int k = 0; k < _tuning.powerfulStarts && !isOver(work); ++k)
    {
        arriveFrom(field, startLane(field, k, _tuning.powerfulStarts));
        for (int round = 0; round < _tuning.powerRounds; ++round)
        {
            field.stop().throwIfRequested();
            weighPhases(field, field.a);
            field.backward(field.w, field.z);
            field.forward(field.z, field.p);
            field.phasesOf(field.p);
        }
        const float power = field.a.dot(field.y);
        if (k > 0 && !(power > most)) continue;
        most = power;
        copy(field.u, _powerful, n);
    }
    copy(_powerful, field.u, n);
    startFrom(work, _tuning.powerfulLevel, _tuning.leastCold, _tuning.coldDamped);
}

// Starts from the phases of one transducer's wave at the points, which have no zeros between them.
// Several transducers are tried.
void CrowdedDescent::beginSmoothly(Work& work)
{
    int bestLane = 0;
    float best = 0.0f;
    const auto tryLane = [&](int lane, int steps)
    {
        arriveFrom(work.field, lane);
        startFrom(work, _tuning.smoothLevel, _tuning.leastSmooth, steps);
    };
    for (int k = 0; k < _tuning.smoothStarts && !isOver(work); ++k)
    {
        const int lane = startLane(work.field, k, _tuning.smoothStarts);
        tryLane(lane, _tuning.smoothTrial);
        if (k > 0 && !(work.error < best)) continue;
        best = work.error;
        bestLane = lane;
    }
    tryLane(bestLane, _tuning.coldDamped);
}

// A descent from the projection of the phases field.u, at the share \a level of its level.
void CrowdedDescent::startFrom(Work& work, float level, float leastLevel, int steps)
{
    FieldProblem& field = work.field;
    projectionRound(field, field.a);
    work.begin(field);
    work.level = level * bestLevel(field, work.quiet);
    fit(work, steps, leastLevel * work.level);
}

} // namespace midair::haptics
