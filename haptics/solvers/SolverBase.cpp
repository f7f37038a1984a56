#include "haptics/solvers/SolverBase.h"

#include "haptics/base/InputError.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/AudibleChange.h"
#include "haptics/solvers/WeightedRound.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// haptics/SOLVER.md explains these in "Points out of reach" and "Louder than accurate".
constexpr double kReach = 1e-3;      // least row sum of G, over the largest, of a point in reach
constexpr int kLouderRounds = 3;     // rounds that show which points are cheap
constexpr float kLeastShare = 1e-3f; // least share of its target that a point counts as having

std::string pointRefusal(const ControlPoints& points)
{
    for (int l = 0; l < points.size(); ++l)
    {
        const Eigen::Vector3d r = points.positions.col(l);
        if (!r.allFinite())
            return fmt::format(
                "control point {} is at ({:g}, {:g}, {:g}); coordinates must be finite",
                l,
                r[0],
                r[1],
                r[2]);
        const double target = points.targets[l];
        if (!(target >= 0.0) || target > 1e12)
            return fmt::format(
                "control point {} has the target {:g}; targets are 0 .. 1e12", l, target);
    }
    return {};
}

std::string arrayRefusal(const TransducerArray& array)
{
    const int m = array.size();
    if (m == 0) return "the array has no transducers";
    if (array.normals.cols() != m)
        return fmt::format("the array has {} positions and {} normals", m, array.normals.cols());
    for (const Eigen::VectorXd* v : {&array.gain, &array.phaseOffset_rad})
        if (v->size() != 0 && (v->size() != m || !v->allFinite()))
            return fmt::format(
                "the array's gains and phase offsets must be {} finite numbers or none", m);
    if (!array.positions.allFinite() || !array.normals.allFinite())
        return "the array has a position or normal that is not finite";
    if (!(array.frequency_Hz > 0.0) || !std::isfinite(array.frequency_Hz))
        return fmt::format("the array's frequency is {:g} Hz; it must be positive",
                           array.frequency_Hz);
    if (!(array.sourceAmplitude_Pa_m > 0.0) || !std::isfinite(array.sourceAmplitude_Pa_m))
        return fmt::format("the array's source amplitude is {:g} Pa m; it must be positive",
                           array.sourceAmplitude_Pa_m);
    return {};
}

} // namespace

SolverBase::SolverBase(std::string name, const SolverOptions& options, Storage storage) :
    _name(std::move(name)),
    _options(options),
    _louder(std::max(0.0, options.loudness - 1.0)),
    _audibleShare(audibleShare(options.updateRate_Hz)),
    _field(options.pool ? options.pool : std::make_shared<base::ThreadPool>(options.threads),
           storage,
           options.stop)
{
    _options.loudness = std::min(options.loudness, 1.0);
}

// Returns why the problem is too large; empty if it is not.
std::string SolverBase::tooLarge(int points, int transducers) const
{
    if (points > mostPoints())
        return fmt::format(
            "there are {} control points; {} is for at most {}", points, _name, mostPoints());
    if (static_cast<std::size_t>(points) * static_cast<std::size_t>(transducers) >
        base::kMostEntries)
        return fmt::format("{} control points and {} transducers are more than can be solved for; "
                           "their product must be at most {}",
                           points,
                           transducers,
                           base::kMostEntries);
    return {};
}

std::string SolverBase::refusal(const ControlPoints& points,
                                const TransducerArray& array,
                                const Medium& medium,
                                bool isKnown) const
{
    std::string why;
    if (!medium.isValid(&why)) return why;
    why = tooLarge(points.size(), array.size());
    if (!why.empty()) return why;
    if (points.targets.size() != points.size())
        return fmt::format(
            "there are {} control points and {} targets", points.size(), points.targets.size());
    if (!isKnown) why = arrayRefusal(array);
    return why.empty() ? pointRefusal(points) : why;
}

void SolverBase::chooseActive(const ControlPoints& points)
{
    _active.clear();
    for (int l = 0; l < points.size(); ++l)
        if (points.targets[l] > 0.0) _active.push_back(l);
}

// Leaves out points that no transducer reaches. Returns true if there were any: the field then has
// to be assigned and built again.
bool SolverBase::dropUnreachable()
{
    double best = 0.0;
    for (int l = 0; l < _field.n(); ++l)
        best = std::max(best, _field.rowSum(l));
    const std::size_t before = _active.size();
    std::size_t kept = 0;
    for (int l = 0; l < _field.n(); ++l)
        if (_field.rowSum(l) > kReach * best &&
            _field.rowSum(l) > std::numeric_limits<float>::min())
            _active[kept++] = _active[static_cast<std::size_t>(l)];
    _active.resize(kept);
    return kept != before;
}

bool SolverBase::isSkippable(int stale, const Eigen::VectorXcf& q) const
{
    return stale == 0 && _last.good && _options.warmStart && _active == _last.active &&
           _field.a.cast<double>().isApprox(_last.targets, 1e-7) && q.size() == _last.q.size() &&
           q == _last.q;
}

double SolverBase::skipTolerance_m(const TransducerArray& array, const Medium& medium) const
{
    return _options.skipTolerance * medium.wavelength(array.frequency_Hz);
}

// Divides the targets by the largest: methods use only their ratios.
void SolverBase::scaleTargets()
{
    _largestTarget = _field.a.maxCoeff();
    _field.a /= _largestTarget;
}

bool SolverBase::isContinued(const TransducerArray& array) const
{
    return _options.warmStart && _last.good && _last.q.size() == array.size() &&
           _active == _last.active;
}

// Sets the starting phases: those of the last field, which are computed at the points if these have
// changed; without a last field all are 1. Returns true if the points correspond to the last
// field's.
bool SolverBase::prepareStart(const TransducerArray& array)
{
    const bool warm = _options.warmStart && _last.good && _last.q.size() == array.size();
    if (!warm)
    {
        for (int l = 0; l < _field.n(); ++l)
            _field.u.set(static_cast<std::size_t>(l), 1.0f);
        return false;
    }
    if (isContinued(array)) return true;
    _field.toLanes(_last.q, _field.q);
    _field.forward(_field.q, _field.p);
    _field.phasesOf(_field.p);
    return false;
}

// Trades accuracy for loudness (SOLVER.md, "Louder than accurate"): a few rounds with the targets
// as weights show which points are cheap, and the targets are shifted towards those pressures.
SolverBase::Outcome SolverBase::iterateLouder(bool warm)
{
    Outcome first;
    if (!warm)
    {
        first = iterate(_field, false);
        if (outOfTime(_field)) return first;
    }
    const auto n = static_cast<std::size_t>(_field.n());
    _keptU.reserve(n);
    _keptA = _field.a;
    std::copy_n(_field.u.re.data(), n, _keptU.re.data());
    std::copy_n(_field.u.im.data(), n, _keptU.im.data());
    for (int round = 0; round < kLouderRounds; ++round)
        projectionRound(_field, _keptA);
    const float s = fittedLevel(_field.y, _keptA);
    const auto x = static_cast<float>(_beyond);
    for (Eigen::Index l = 0; l < _keptA.size(); ++l)
        _field.a[l] = _keptA[l] * std::pow(std::max(_field.y[l] / (s * _keptA[l]), kLeastShare), x);
    std::copy_n(_keptU.re.data(), n, _field.u.re.data());
    std::copy_n(_keptU.im.data(), n, _field.u.im.data());
    Outcome outcome = iterate(_field, true);
    outcome.iterations += first.iterations + kLouderRounds;
    _field.a = _keptA;
    return outcome;
}

SolveReport SolverBase::solve(const ControlPoints& points,
                              const TransducerArray& array,
                              const Medium& medium,
                              Eigen::VectorXcf& q)
{
    _field.start();
    try
    {
        return solveUnlessStopped(points, array, medium, q);
    }
    catch (const base::Stopped& stopped)
    {
        SolveReport result;
        result.solver = _name;
        result.points = points.size();
        result.transducers = array.size();
        result.solve_ms = _field.elapsed_ms();
        return silent(result, StopReason::STOPPED, stopped.what(), array.size(), q);
    }
}

SolveReport SolverBase::solveUnlessStopped(const ControlPoints& points,
                                           const TransducerArray& array,
                                           const Medium& medium,
                                           Eigen::VectorXcf& q)
{
    _options.stop.throwIfRequested();
    SolveReport result;
    result.solver = _name;
    result.points = points.size();
    result.transducers = array.size();
    const bool isKnown = _field.isBoundTo(array, medium);
    const std::string why = refusal(points, array, medium, isKnown);
    if (!why.empty()) return silent(result, StopReason::REFUSED, why, array.size(), q);
    // A field for targets of the other kind is no warm start: its level means something else.
    if (points.size() > 0 && points.absolute != _absolute) _last.good = false;
    if (points.size() > 0) _absolute = points.absolute;
    _beyond = _absolute ? 0.0 : _louder;
    chooseActive(points);
    if (_active.empty())
        return silent(result,
                      StopReason::NOTHING_TO_DO,
                      points.size() == 0 ? "there are no control points" : "every target is 0",
                      array.size(),
                      q);

    const int stale =
        _field.assign(points, _active, array, medium, skipTolerance_m(array, medium), isKnown);
    if (!isKnown && _last.q.size() == array.size()) _field.toLanes(_last.q, _last.lanes);
    if (isSkippable(stale, q))
    {
        result = _last.report;
        result.stop = StopReason::SKIPPED;
        result.rowsBuilt = result.iterations = 0;
        result.matrix_ms = result.solve_ms = 0.0;
        result.meanPhaseStep_rad = result.driveChange = result.audibleChange = 0.0;
        return result;
    }
    return solveAssigned(points, array, medium, stale, result, q);
}

// Solves for the points that are assigned, of which \a stale still need their rows of G.
SolveReport SolverBase::solveAssigned(const ControlPoints& points,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      int stale,
                                      SolveReport& result,
                                      Eigen::VectorXcf& q)
{
    // Above the accurate loudness the targets are shifted first, so that the build can't be
    // combined with the first round.
    const bool continues = isContinued(array) && _beyond == 0.0;
    if (continues)
        build(_field);
    else
        _field.build();
    result.matrix_ms = _field.build_ms();
    if (dropUnreachable())
    {
        if (_active.empty())
            return silent(result,
                          StopReason::NOTHING_TO_DO,
                          "no transducer reaches any control point",
                          array.size(),
                          q);
        stale +=
            _field.assign(points, _active, array, medium, skipTolerance_m(array, medium), true);
        _field.build();
        result.matrix_ms += _field.build_ms();
    }
    result.rowsBuilt = stale;

    scaleTargets();
    const bool warm = prepareStart(array);
    const Outcome outcome = _beyond > 0.0 ? iterateLouder(warm) : iterate(_field, warm);
    if (!outcome.playable) makePlayable();
    report(outcome, result);
    result.solve_ms = _field.elapsed_ms() - result.matrix_ms;
    if (!std::isfinite(result.rms) || !(result.loudness > 0.0))
        return silent(
            result, StopReason::REFUSED, "the field did not come out finite", array.size(), q);
    keep(result, q);
    return result;
}

SolveReport
SolverBase::silent(SolveReport result, StopReason stop, std::string why, int m, Eigen::VectorXcf& q)
{
    q.setZero(m);
    _last.good = false;
    _field.forget();
    result.stop = stop;
    result.message = std::move(why);
    result.rms = result.max = result.loudness = result.level_Pa = 0.0;
    result.leftOut = result.points;
    return result;
}

} // namespace midair::haptics
