#include "haptics/solvers/production/CrowdedDescent.h"

#include "haptics/solvers/FieldFigures.h"
#include "haptics/solvers/WeightedRound.h"

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

// The level for which f is least; with quiet points, some of which may be far too loud, the fitted
// one.
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

// The phase of the wave of one transducer at one point.
std::complex<float> arriving(const FieldProblem& field, int point, int lane)
{
    const std::complex<float> entry = field.G.at(point, lane);
    const float size = std::abs(entry);
    return size > kLeastPressure ? entry / size : 1.0f;
}

} // namespace

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
    if (!_beganAnew)
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
// not become much quieter. They are moved with the points: a transducer whose wave arrives later
// now has to begin earlier.
bool CrowdedDescent::takeKept(Work& work)
{
    FieldProblem& field = work.field;
    const int m = field.m();
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

// At most \a most damped steps. The level follows the field downwards to \a leastLevel.
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

// A descent from the projection. If that ends in a field with zeros between the points, another one
// from smooth phases; then more at lower levels, as long as the error is not small.
void CrowdedDescent::beginAnew(Work& work)
{
    work.level = bestLevel(work.field, work.quiet);
    fit(work, _tuning.coldDamped, _tuning.leastCold * work.level);
    if (work.error > _tuning.poor && !isOver(work)) beginSmoothly(work);
    for (int k = 0; k < _tuning.lowerings && work.error > _tuning.fair && !isOver(work); ++k)
    {
        work.level *= _tuning.lowering;
        fit(work, _tuning.coldDamped / 3, work.level);
    }
    raise(work);
    _loudness = loudnessAt(work.field, fittedLevel(work.field));
}

// Makes a field that fits louder, as long as it still does.
void CrowdedDescent::raise(Work& work)
{
    FieldProblem& field = work.field;
    const auto padded = static_cast<std::size_t>(field.G.paddedTransducers());
    _quieter.reserve(padded);
    for (int k = 0; k < _tuning.raisings && work.error < _tuning.fair &&
                    loudnessAt(field, work.level) < _tuning.loud && !isOver(work);
         ++k)
    {
        const float level = work.level;
        copy(work.drive.phases(), _quieter, padded);
        work.level *= _tuning.raising;
        fit(work, _tuning.coldDamped / 3, level);
        if (work.error < _tuning.fair) continue;
        copy(_quieter, work.drive.phases(), padded);
        work.drive.measure(field);
        work.level = level;
        work.error = errorAt(field, work.quiet, level);
        return;
    }
}

// Starts from the phases that one transducer's wave has at the points: these have no zeros between
// them. Several transducers are tried.
void CrowdedDescent::beginSmoothly(Work& work)
{
    int bestLane = 0;
    float best = 0.0f;
    for (int k = 0; k < _tuning.smoothStarts && !isOver(work); ++k)
    {
        const int lane = (2 * k + 1) * work.field.m() / (2 * _tuning.smoothStarts);
        startFrom(work, lane, _tuning.smoothTrial);
        if (k > 0 && !(work.error < best)) continue;
        best = work.error;
        bestLane = lane;
    }
    startFrom(work, bestLane, _tuning.coldDamped);
}

void CrowdedDescent::startFrom(Work& work, int lane, int steps)
{
    FieldProblem& field = work.field;
    for (int l = 0; l < field.n(); ++l)
        field.u.set(static_cast<std::size_t>(l), arriving(field, l, lane));
    projectionRound(field, field.a);
    work.begin(field);
    work.level = _tuning.smoothLevel * bestLevel(field, work.quiet);
    fit(work, steps, _tuning.leastSmooth * work.level);
}

} // namespace midair::haptics
