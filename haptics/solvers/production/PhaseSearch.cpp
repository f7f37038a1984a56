#include "haptics/solvers/production/PhaseSearch.h"

#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <random>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "Quiet points".
constexpr float kQuietStep = 0.5f;    // share of a linear step per round
constexpr float kLeastOfMean = 0.25f; // smallest weight of a formerly quiet point, over the mean

} // namespace

void PhaseSearch::build(FieldProblem& field)
{
    _projected = _weightsOf == field.n();
    if (!_projected) return field.build();
    adapt(field, field.a / field.a.maxCoeff());
    weigh(field);
    field.buildAndProject(field.w, field.p);
    field.phasesOf(field.p);
}

bool PhaseSearch::carryOver(const FieldProblem& field, const std::vector<int>& lastOf)
{
    if (_weightsOf == 0 || _weights.size() != _weightsOf) return false;
    const Eigen::VectorXf last = _weights, lastTargets = _targets;
    copy(_multiplier, _bestMultiplier, static_cast<std::size_t>(_weightsOf));
    _weights.resize(field.n());
    _targets = field.a;
    _multiplier.reserve(static_cast<std::size_t>(field.n()));
    float weights = 0.0f, targets = 0.0f; // of the points in the last field
    for (Eigen::Index l = 0; l < _weights.size(); ++l)
    {
        const int from = lastOf[static_cast<std::size_t>(l)];
        _multiplier.set(static_cast<std::size_t>(l), 0.0f);
        if (from < 0) continue;
        _weights[l] = last[from];
        _targets[l] = lastTargets[from];
        if (QuietPoints::isQuiet(_targets[l]))
            _multiplier.set(static_cast<std::size_t>(l),
                            _bestMultiplier.at(static_cast<std::size_t>(from)));
        else
        {
            weights += last[from];
            targets += field.a[l];
        }
    }
    if (!(weights > 0.0f) || !(targets > 0.0f)) return false;
    for (Eigen::Index l = 0; l < _weights.size(); ++l)
        if (lastOf[static_cast<std::size_t>(l)] < 0)
            _weights[l] = QuietPoints::isQuiet(field.a[l]) ? 0.0f : field.a[l] * weights / targets;
    _weightsOf = field.n();
    return true;
}

// Adapts the multipliers to the new targets \a targets, largest 1: for points that don't disturb
// each other a weight is proportional to the target.
void PhaseSearch::adapt(const FieldProblem& field, const Eigen::VectorXf& targets)
{
    const bool wasAny = _quiet.any();
    _quiet.choose(targets, field.m());
    _isJump = false;
    if (_targets.size() != targets.size() || _targets == targets) return;
    _isJump = _follows && (wasAny || _quiet.any()) &&
              (targets - _targets).norm() > _tuning.targetsJump * _targets.norm();
    float weights = 0.0f, sum = 0.0f; // of the points that were not quiet
    for (Eigen::Index l = 0; l < targets.size(); ++l)
        if (!QuietPoints::isQuiet(_targets[l]))
        {
            weights += _weights[l];
            sum += _targets[l];
        }
    for (Eigen::Index l = 0; l < targets.size(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        const bool was = QuietPoints::isQuiet(_targets[l]), is = QuietPoints::isQuiet(targets[l]);
        if (was && !is)
            _weights[l] = std::max(alongPhase(field, static_cast<int>(l)),
                                   kLeastOfMean * targets[l] * weights / sum);
        if (!was && _follows) _weights[l] *= targets[l] / _targets[l];
        if (was || !is) continue;
        _multiplier.set(row, _weights[l] * field.u.at(row));
        _weights[l] = 0.0f;
    }
    _targets = targets;
}

void PhaseSearch::weigh(FieldProblem& field) const
{
    weighPhases(field, _weights);
    for (const int l : _quiet.points())
    {
        const auto row = static_cast<std::size_t>(l);
        field.w.set(row, _multiplier.at(row));
    }
}

// The multipliers of quiet points take a step of their linear equations. Without mutual disturbance
// p_l would be proportional to c_l, as it is to w_l at the others.
void PhaseSearch::reweigh(FieldProblem& field)
{
    haptics::reweigh(field, _weights, _tuning.mostReweighing);
    if (!_quiet.any()) return;
    const float s = fittedLevel(field);
    float loud = field.y.sum();
    for (const int l : _quiet.points())
        loud -= field.y[l];
    const float step = kQuietStep * _weights.sum() / std::max(loud, kLeastPressure);
    for (const int l : _quiet.points())
    {
        const auto row = static_cast<std::size_t>(l);
        const std::complex<float> lack = s * field.a[l] * field.u.at(row) - field.p.at(row);
        _multiplier.set(row, _multiplier.at(row) + step * lack);
    }
}

const Eigen::VectorXf& PhaseSearch::weights(const FieldProblem& field)
{
    if (!_quiet.any()) return _weights;
    const std::vector<int>& twice = _quiet.twice();
    const int n = field.n();
    _rows.resize(n + static_cast<int>(twice.size()));
    _rows.head(n) = _weights;
    for (const int l : _quiet.points())
        _rows[l] = alongPhase(field, l);
    for (std::size_t k = 0; k < twice.size(); ++k)
    {
        const auto row = static_cast<std::size_t>(twice[k]);
        _rows[n + static_cast<int>(k)] =
            std::imag(_multiplier.at(row) * std::conj(field.u.at(row)));
    }
    return _rows;
}

void PhaseSearch::adjust(const GaussNewtonStep& step, float amplitude)
{
    const auto n = static_cast<int>(_weights.size());
    const auto add = [&](int l, int k)
    {
        const auto row = static_cast<std::size_t>(l);
        _multiplier.set(row,
                        _multiplier.at(row) + amplitude * step.multiplier(k) * step.direction(k));
    };
    for (int l = 0; l < n; ++l)
        _weights[l] = std::max(_weights[l] + amplitude * step.multiplier(l),
                               _tuning.leastOfWeight * _weights[l]);
    for (const int l : _quiet.points())
    {
        _weights[l] = 0.0f;
        add(l, l);
    }
    for (std::size_t k = 0; k < _quiet.twice().size(); ++k)
        add(_quiet.twice()[k], n + static_cast<int>(k));
}

void PhaseSearch::turn(std::complex<float> by)
{
    for (const int l : _quiet.points())
    {
        const auto row = static_cast<std::size_t>(l);
        _multiplier.set(row, _multiplier.at(row) * by);
    }
}

void PhaseSearch::normalise()
{
    const float mean = _weights.sum() / static_cast<float>(_weights.size() - _quiet.count());
    if (!_quiet.any())
        _weights /= _weights.mean();
    else
    {
        _weights /= mean;
        turn(1.0f / mean);
    }
}

void PhaseSearch::reserve(const FieldProblem& field)
{
    for (SplitVector* v : {&_startU, &_bestU, &_multiplier, &_bestMultiplier})
        v->reserve(static_cast<std::size_t>(field.n()));
    for (Eigen::VectorXf* v : {&_weights, &_bestWeights})
        if (v->size() != field.n()) v->resize(field.n());
}

void PhaseSearch::weighByTargets(const FieldProblem& field)
{
    _weights = field.a;
    for (const int l : _quiet.points())
    {
        _weights[l] = 0.0f;
        _multiplier.set(static_cast<std::size_t>(l), 0.0f);
    }
}

void PhaseSearch::begin(const FieldProblem& field)
{
    reserve(field);
    _quiet.choose(field.a, field.m());
    weighByTargets(field);
    _weightsOf = field.n();
    _targets = field.a;
}

Eigen::VectorXcf PhaseSearch::multipliers(const FieldProblem& field) const
{
    if (_weightsOf != field.n()) return {};
    Eigen::VectorXcf c(field.n());
    for (Eigen::Index l = 0; l < c.size(); ++l)
        c[l] = _weights[l] * field.u.at(static_cast<std::size_t>(l));
    for (const int l : _quiet.points())
        c[l] = _multiplier.at(static_cast<std::size_t>(l));
    return c;
}

bool PhaseSearch::take(FieldProblem& field, const Eigen::VectorXcf& c)
{
    if (_weightsOf != field.n() || c.size() != field.n()) return false;
    for (Eigen::Index l = 0; l < c.size(); ++l)
    {
        _weights[l] = std::abs(c[l]);
        if (_weights[l] > 0.0f) field.u.set(static_cast<std::size_t>(l), c[l] / _weights[l]);
    }
    for (const int l : _quiet.points())
    {
        _multiplier.set(static_cast<std::size_t>(l), c[l]);
        _weights[l] = 0.0f;
    }
    _loudest = _previous = 0.0f;
    return true;
}

void PhaseSearch::improve(FieldProblem& field, int count, Pace& pace)
{
    rounds(field, _tuning.roundsBeforeWeights, _tuning.roundsBeforeWeights + count, pace);
    round(field, pace);
}

int PhaseSearch::search(FieldProblem& field, bool warm, int limit, std::uint64_t seed, Pace& pace)
{
    reserve(field);
    _projected = _projected && warm;
    _wasCold = !warm || _weightsOf != field.n();
    _isJump = _isJump && !_wasCold;
    if (_wasCold)
        _quiet.choose(field.a, field.m());
    else if (!_projected)
        adapt(field, field.a);
    _weightsOf = field.n();
    _targets = field.a;
    int made = 0;
    if (_wasCold)
    {
        made = coldStart(field, limit, seed, pace);
        _loudest = loudness(field);
    }
    // After the last weights of a cold start only if time remains, because a round has been made.
    if (!_projected && (made == 0 || pace.fits(Pace::ROUND, 1) > 0))
    {
        round(field, pace);
        ++made;
    }
    _projected = false;
    if (!_wasCold && (_isJump || loudness(field) < _tuning.lost * _previous))
    {
        // After a jump of the object, a permutation of its points or other targets, some of them
        // quiet, the last phases are as good as random, and improving them would take tens of
        // updates.
        _wasCold = true;
        made += coldStart(field, limit, seed, pace);
        _loudest = loudness(field);
    }
    if (!_wasCold) made += keepLoud(field, limit, pace);
    _previous = loudness(field);
    return std::max(made, 1);
}

float PhaseSearch::naturalLevel(const FieldProblem& field) const
{
    if (!_quiet.any()) return weightedLevel(_weights, field.y, field.a);
    float pressures = _weights.dot(field.y), targets = _weights.dot(field.a);
    for (const int l : _quiet.points())
    {
        const float along = alongPhase(field, l);
        pressures += along * field.y[l];
        targets += along * field.a[l];
    }
    // Multipliers of quiet points may oppose the field; if they outweigh it, no level is reached.
    return pressures > 0.0f && targets > 0.0f ? pressures / targets : fittedLevel(field);
}

float PhaseSearch::loudness(const FieldProblem& field) const
{
    return loudnessAt(field, naturalLevel(field));
}

void PhaseSearch::round(FieldProblem& field, Pace& pace)
{
    pace.timed(Pace::ROUND,
               1,
               [&]
               {
                   weigh(field);
                   field.projectRound(field.w, field.p);
                   field.phasesOf(field.p);
               });
}

// Phases that follow a moving object drift into poorer local optima. A field quieter than the
// recent ones therefore gets additional rounds, each of which raises the loudness.
int PhaseSearch::keepLoud(FieldProblem& field, int limit, Pace& pace)
{
    int made = 0;
    while (made < _tuning.quietRounds && loudness(field) < _leastShare * _loudest &&
           made + 2 < limit && pace.fits(Pace::ROUND, 1) > 0)
    {
        reweigh(field);
        round(field, pace);
        ++made;
    }
    _loudest = std::max(_tuning.forget * _loudest, loudness(field));
    return made;
}

int PhaseSearch::rounds(FieldProblem& field, int first, int last, Pace& pace)
{
    int made = 0;
    for (int k = first; k < last && (k == 0 || pace.fits(Pace::ROUND, 1) > 0); ++k, ++made)
    {
        field.stop().throwIfRequested();
        round(field, pace);
        if (k >= _tuning.roundsBeforeWeights) reweigh(field);
    }
    return made;
}

// Tries several sets of starting phases and continues with the loudest: the phases determine the
// level, while corrections remove the error from any of them.
int PhaseSearch::coldStart(FieldProblem& field, int limit, std::uint64_t seed, Pace& pace)
{
    constexpr auto kFullTurn_rad = static_cast<float>(base::kTwoPi);
    const auto n = static_cast<std::size_t>(field.n());
    std::mt19937_64 random(seed);
    copy(field.u, _startU, n);
    const int trial = std::min(_tuning.trialRounds, limit);
    const int starts = limit > _tuning.trialRounds ? _tuning.coldStarts : 1;
    int made = 0, bestStart = 0, lastStart = 0;
    float best = 0.0f;
    for (int start = 0; start < starts && (start == 0 || pace.fits(Pace::ROUND, 1) > 0); ++start)
    {
        for (std::size_t l = 0; l < n; ++l)
        {
            const float turn = kFullTurn_rad * static_cast<float>(random() >> 40) * 0x1p-24f;
            field.u.set(l, start == 0 ? _startU.at(l) : std::polar(1.0f, turn));
        }
        weighByTargets(field);
        made += rounds(field, 0, trial, pace);
        lastStart = start;
        const float level = naturalLevel(field);
        if (start > 0 && !(level > best)) continue;
        best = level;
        bestStart = start;
        _bestWeights = _weights;
        copy(_multiplier, _bestMultiplier, n);
        copy(field.u, _bestU, n);
    }
    _weights = _bestWeights;
    copy(_bestMultiplier, _multiplier, n);
    copy(_bestU, field.u, n);
    const int more = rounds(field, trial, std::min(_tuning.coldRounds, limit), pace);
    if (more > 0 || bestStart == lastStart) return made + more;
    round(field, pace); // otherwise q and p would belong to another start
    return made + 1;
}

} // namespace midair::haptics
