#include "haptics/solvers/SolverBase.h"

#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// haptics/SOLVER.md explains these in "Points out of reach" and "Louder than accurate".
constexpr int kLouderRounds = 3;           // rounds that show which points are cheap
constexpr double kDeadlineMargin = 1.2;    // a deadline counts as kept within this factor
constexpr double kDeadlineMargin_ms = 0.1; // or this much
constexpr double kProgress = 0.99; // ratio of errors below which an unfinished field makes progress
constexpr int kMisses = 3;         // in a row, before a report
constexpr float kLeastShare = 1e-3f; // smallest assumed share of its target that a point has

constexpr double kMostOutside_Pa = 1e12; // as for targets

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

std::string
outsideRefusal(const ControlPoints& points, const TransducerArray& array, const Eigen::VectorXcf& q)
{
    if (const Eigen::MatrixXcf* rows = points.outsideRows_Pa.get())
    {
        if (rows->rows() != points.size() || rows->cols() != array.size())
            return fmt::format("the outside rows are {} x {}; for {} control points and {} "
                               "transducers they must be {} x {}",
                               rows->rows(),
                               rows->cols(),
                               points.size(),
                               array.size(),
                               points.size(),
                               array.size());
        if (!rows->allFinite() ||
            (rows->size() > 0 && rows->cwiseAbs().maxCoeff() > float(kMostOutside_Pa)))
            return fmt::format("the outside rows must be finite and at most {:g} Pa",
                               kMostOutside_Pa);
    }
    const Eigen::VectorXcd& o = points.outside_Pa;
    if (o.size() == 0) return {};
    if (o.size() != points.size())
        return fmt::format(
            "there are {} control points and {} outside pressures", points.size(), o.size());
    for (Eigen::Index l = 0; l < o.size(); ++l)
        if (!(std::abs(o[l]) <= kMostOutside_Pa))
            return fmt::format("control point {} has the outside pressure ({:g}, {:g}) Pa; it must "
                               "be at most {:g}",
                               l,
                               o[l].real(),
                               o[l].imag(),
                               kMostOutside_Pa);
    double power = 0.0; // of transducers that sound
    for (int i = 0; q.size() == array.size() && i < array.size(); ++i)
        if (array.gain.size() == 0 || array.gain[i] != 0.0) power += std::norm(q[i]);
    if (!(power > 0.0) || !q.allFinite())
        return fmt::format("outside pressures belong to the drive that is passed, which must be "
                           "{} finite activations, not all 0",
                           array.size());
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
    if (!(array.sourceAmplitude_Pa_m >= kLeastSource_Pa_m) ||
        array.sourceAmplitude_Pa_m > kMostSource_Pa_m)
        return fmt::format("the array's source amplitude is {:g} Pa m; it must be within {:g} .. "
                           "{:g}",
                           array.sourceAmplitude_Pa_m,
                           kLeastSource_Pa_m,
                           kMostSource_Pa_m);
    std::string why;
    areValid(array.reflectors, &why);
    return why;
}

// Nearer than a wavelength to a reflector neither its image nor its edges are a wave of the model.
std::string
reflectorRefusal(const ControlPoints& points, const TransducerArray& array, double wavelength_m)
{
    for (std::size_t k = 0; k < array.reflectors.size(); ++k)
        for (int l = 0; l < points.size(); ++l)
        {
            const Reflector& one = array.reflectors[k];
            const double distance_m = one.distanceTo(points.positions.col(l));
            if (one.reflection > 0.0 && distance_m < wavelength_m)
                return fmt::format("control point {} is {:.2g} mm from {}; its field is known only "
                                   "from a wavelength on, {:.2g} mm",
                                   l,
                                   1e3 * distance_m,
                                   one.called(k),
                                   1e3 * wavelength_m);
        }
    return {};
}

constexpr double kReach = 1e-3; // SOLVER.md, "Points out of reach": least row sum, over the largest
/// Smallest share of points in the last field for continuing from its phases.
constexpr double kLeastKnown = 0.5;

} // namespace

SolverBase::SolverBase(std::string name, const SolverOptions& options, Storage storage) :
    _name(std::move(name)),
    _field(options.pool ? options.pool : std::make_shared<base::ThreadPool>(options.threads),
           storage,
           options.stop)
{
    take(options);
}

void SolverBase::take(const SolverOptions& options)
{
    _options = options;
    _options.loudness = std::min(options.loudness, 1.0);
    _field.G.buildQuickly(isCoarseTolerance(options.rmsTolerance));
    _loudness.wanted = std::max(0.0, options.loudness - 1.0);
    _audibleShare = audibleShare(options.updateRate_Hz);
}

bool SolverBase::setOptions(const SolverOptions& options)
{
    if (options.pool != _options.pool || (!options.pool && options.threads != _options.threads))
        return false;
    take(options);
    _last.goesOn = true; // otherwise the next solve could be skipped
    return true;
}

// Returns the reason if the problem is too large; otherwise empty.
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
                                const Eigen::VectorXcf& q,
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
    if (why.empty()) why = pointRefusal(points);
    if (why.empty()) why = outsideRefusal(points, array, q);
    if (why.empty()) why = reflectorRefusal(points, array, medium.wavelength(array.frequency_Hz));
    return why;
}

bool SolverBase::isSkippable(int stale, const Eigen::VectorXcf& q) const
{
    return stale == 0 && _last.good && _options.warmStart && areLastPoints() && !_last.goesOn &&
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
    _targets.largest = _field.a.maxCoeff();
    _field.a /= _targets.largest;
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
    _loudness.u.reserve(n);
    _loudness.a = _field.a;
    copy(_field.u, _loudness.u, n);
    for (int round = 0; round < kLouderRounds; ++round)
        projectionRound(_field, _loudness.a);
    const float s = fittedLevel(_field.y, _loudness.a);
    const auto x = static_cast<float>(_loudness.now);
    for (Eigen::Index l = 0; l < _loudness.a.size(); ++l)
        _field.a[l] =
            _loudness.a[l] * std::pow(std::max(_field.y[l] / (s * _loudness.a[l]), kLeastShare), x);
    copy(_loudness.u, _field.u, n);
    Outcome outcome = iterate(_field, true);
    outcome.iterations += first.iterations + kLouderRounds;
    _field.a = _loudness.a;
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
    _last.achieved_Pa.resize(0);
    SolveReport result;
    result.solver = _name;
    result.points = points.size();
    result.transducers = array.size();
    const bool isKnown = _field.isBoundTo(array, medium);
    const std::string why = refusal(points, array, medium, q, isKnown);
    if (!why.empty()) return silent(result, StopReason::REFUSED, why, array.size(), q);
    // A field for targets of the other kind is no warm start: its level has another meaning.
    if (points.size() > 0 && points.absolute != _targets.isAbsolute) _last.good = false;
    if (points.size() > 0) _targets.isAbsolute = points.absolute;
    _loudness.now = _targets.isAbsolute ? 0.0 : _loudness.wanted;
    chooseActive(points);
    if (_points.active.empty())
        return silent(result,
                      StopReason::NOTHING_TO_DO,
                      points.size() == 0 ? "there are no control points" : "every target is 0",
                      array.size(),
                      q);

    const int stale = _field.assign(
        points, _points.active, array, medium, skipTolerance_m(array, medium), isKnown, q);
    _targets.raised = raiseTargets(_field.a);
    if (!isKnown && _last.q.size() == array.size()) _field.toLanes(_last.q, _last.lanes);
    if (isSkippable(stale, q))
    {
        result = _last.report;
        result.stop = StopReason::SKIPPED;
        result.rowsBuilt = result.iterations = 0;
        result.matrix_ms = result.solve_ms = 0.0;
        result.meanPhaseStep_rad = result.driveChange = result.audibleChange = 0.0;
        result.levelJump = 1.0;
        return result;
    }
    return solveAssigned(points, array, medium, stale, result, q);
}

// Solves for the assigned points, of which \a stale still need their rows of G.
SolveReport SolverBase::solveAssigned(const ControlPoints& points,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      int stale,
                                      SolveReport& result,
                                      Eigen::VectorXcf& q)
{
    // Above the accurate loudness the targets are shifted first, so that the build can't be
    // combined with the first round.
    const bool continues = isContinued(array) && _loudness.now == 0.0;
    if (continues)
        build(_field);
    else
        _field.build();
    result.matrix_ms = _field.build_ms();
    if (dropUnreachable())
    {
        if (_points.active.empty())
            return silent(result,
                          StopReason::NOTHING_TO_DO,
                          "no transducer reaches any control point",
                          array.size(),
                          q);
        stale += _field.assign(
            points, _points.active, array, medium, skipTolerance_m(array, medium), true, q);
        _targets.raised = raiseTargets(_field.a);
        _field.build();
        result.matrix_ms += _field.build_ms();
    }
    result.rowsBuilt = stale;

    scaleTargets();
    const bool warm = prepareStart(array);
    const double lastRms = _last.report.rms, lastOfLargest = _last.report.rmsOfLargest;
    Outcome outcome = _loudness.now > 0.0 ? iterateLouder(warm) : iterate(_field, warm);
    if (!outcome.playable) makePlayable();
    keepToTargets(outcome);
    measure(outcome, points, array, medium);
    report(outcome, result);
    result.solve_ms = _field.elapsed_ms() - result.matrix_ms;
    if (result.level_Pa == 0.0)
        return silent(result, StopReason::NOTHING_TO_DO, tooQuiet(), array.size(), q);
    tellDeadline(result);
    if (!std::isfinite(result.rms) || !(result.loudness > 0.0))
        return silent(
            result, StopReason::REFUSED, "the field did not come out finite", array.size(), q);
    keep(result, q);
    _last.goesOn = outcome.unfinished && (!warm || result.rms < kProgress * lastRms ||
                                          result.rmsOfLargest < kProgress * lastOfLargest);
    return result;
}

// Message for the case that all amplitudes were rounded to 0.
std::string SolverBase::tooQuiet() const
{
    if (_targets.isAbsolute)
        return fmt::format("the targets, at most {:g} Pa, are below the least that {} can play on "
                           "this array: ask for more",
                           _targets.largest,
                           _name);
    return fmt::format(
        "a loudness of {:g} is below the least amplitude of this array: ask for more",
        _options.loudness);
}

// One miss may be due to the machine; several are not. The text contains no time, so that it is
// reported once.
void SolverBase::tellDeadline(SolveReport& result)
{
    const double deadline_ms = _options.deadline_ms;
    const double most_ms =
        std::max(kDeadlineMargin * deadline_ms, deadline_ms + kDeadlineMargin_ms);
    const bool isMissed = deadline_ms > 0.0 && result.matrix_ms + result.solve_ms > most_ms;
    _misses = isMissed ? _misses + 1 : 0;
    if (_misses < kMisses) return;
    result.message +=
        fmt::format("{}a field for {} control points takes longer than the deadline of {:g} ms",
                    result.message.empty() ? "" : "; ",
                    _field.n(),
                    deadline_ms);
}

SolveReport
SolverBase::silent(SolveReport result, StopReason stop, std::string why, int m, Eigen::VectorXcf& q)
{
    q.setZero(m);
    _last.good = false;
    _field.forget();
    result.stop = stop;
    result.message = std::move(why);
    RelativeErrors().tell(result);
    result.loudness = result.level_Pa = 0.0;
    result.leftOut = result.points;
    return result;
}

void SolverBase::chooseActive(const ControlPoints& points)
{
    _points.active.clear();
    _points.identity.clear();
    const bool isIdentified = static_cast<int>(points.identity.size()) == points.size();
    for (int l = 0; l < points.size(); ++l)
    {
        if (!(points.targets[l] > 0.0)) continue;
        _points.active.push_back(l);
        if (isIdentified) _points.identity.push_back(points.identity[static_cast<std::size_t>(l)]);
    }
}

// Leaves out points that no transducer reaches. Returns true if there were any: the field must then
// be assigned and built again.
bool SolverBase::dropUnreachable()
{
    double best = 0.0;
    for (int l = 0; l < _field.n(); ++l)
        best = std::max(best, _field.rowSum(l));
    const auto isReached = [&](std::size_t l)
    {
        const double sum = _field.rowSum(static_cast<int>(l));
        return sum > kReach * best && sum > std::numeric_limits<float>::min();
    };
    std::size_t kept = 0;
    for (std::size_t l = 0; l < _points.active.size(); ++l)
    {
        if (!isReached(l)) continue;
        _points.active[kept] = _points.active[l];
        if (!_points.identity.empty()) _points.identity[kept] = _points.identity[l];
        ++kept;
    }
    const bool dropped = kept != _points.active.size();
    _points.active.resize(kept);
    if (!_points.identity.empty()) _points.identity.resize(kept);
    return dropped;
}

// Returns true if the points are those of the last field, in its order.
bool SolverBase::areLastPoints() const
{
    if (_points.identity.empty() || _last.identity.empty()) return _points.active == _last.active;
    return _points.identity == _last.identity;
}

bool SolverBase::isContinued(const TransducerArray& array) const
{
    return _options.warmStart && _last.good && _last.q.size() == array.size() && areLastPoints();
}

// Finds each point in the last field. Returns true if enough of them were in it.
bool SolverBase::findLastPoints()
{
    if (_points.identity.empty() || _last.identity.empty()) return false;
    std::unordered_map<std::uint64_t, int> last;
    last.reserve(_last.identity.size());
    for (std::size_t l = 0; l < _last.identity.size(); ++l)
        last.emplace(_last.identity[l], static_cast<int>(l));
    _points.lastOf.clear();
    int known = 0;
    for (const std::uint64_t identity : _points.identity)
    {
        const auto found = last.find(identity);
        _points.lastOf.push_back(found == last.end() ? -1 : found->second);
        known += found != last.end();
    }
    return known >= kLeastKnown * static_cast<double>(_points.identity.size());
}

// Continues from the phases of the points in the last field; new points take the phase that the
// others' field has there. Returns false if the method can't.
bool SolverBase::goOn()
{
    if (!findLastPoints() || !carryOver(_field, _points.lastOf)) return false;
    for (std::size_t l = 0; l < _points.lastOf.size(); ++l)
    {
        const int last = _points.lastOf[l];
        const std::complex<float> u = last < 0 ? 1.0f : _last.u.at(static_cast<std::size_t>(last));
        _field.u.set(l, u);
        _field.w.set(l, last < 0 ? 0.0f : u * _field.a[static_cast<Eigen::Index>(l)]);
    }
    _field.projectRound(_field.w, _field.p);
    for (std::size_t l = 0; l < _points.lastOf.size(); ++l)
    {
        const float pressure = std::abs(_field.p.at(l));
        if (_points.lastOf[l] < 0 && pressure > kLeastPressure)
            _field.u.set(l, _field.p.at(l) / pressure);
    }
    return true;
}

// Sets the starting phases: those of the last field, recomputed at the points if these have
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
    if (isContinued(array) || goOn()) return true;
    _field.toLanes(_last.q, _field.q);
    _field.forward(_field.q, _field.p);
    _field.phasesOf(_field.p);
    return false;
}

} // namespace midair::haptics
