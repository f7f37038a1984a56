#include "haptics/solvers/production/PhaseSearch.h"

#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/solvers/FieldFigures.h"
#include "haptics/solvers/WeightedRound.h"

#include <algorithm>
#include <random>

namespace midair::haptics
{

void PhaseSearch::build(FieldProblem& field)
{
    _projected = _weightsOf == field.n();
    if (!_projected) return field.build();
    weighPhases(field, _weights);
    field.buildAndProject(field.w, field.p);
    field.phasesOf(field.p);
}

bool PhaseSearch::carryOver(const FieldProblem& field, const std::vector<int>& lastOf)
{
    if (_weightsOf == 0 || _weights.size() != _weightsOf) return false;
    const Eigen::VectorXf last = _weights;
    _weights.resize(field.n());
    float weights = 0.0f, targets = 0.0f; // of the points that were in the last field
    for (Eigen::Index l = 0; l < _weights.size(); ++l)
    {
        const int from = lastOf[static_cast<std::size_t>(l)];
        if (from < 0) continue;
        _weights[l] = last[from];
        weights += last[from];
        targets += field.a[l];
    }
    if (!(weights > 0.0f) || !(targets > 0.0f)) return false;
    for (Eigen::Index l = 0; l < _weights.size(); ++l)
        if (lastOf[static_cast<std::size_t>(l)] < 0) _weights[l] = field.a[l] * weights / targets;
    _weightsOf = field.n();
    return true;
}

int PhaseSearch::search(FieldProblem& field, bool warm, int limit, std::uint64_t seed, Pace& pace)
{
    const auto n = static_cast<std::size_t>(field.n());
    for (SplitVector* v : {&_startU, &_bestU})
        v->reserve(n);
    for (Eigen::VectorXf* v : {&_weights, &_bestWeights})
        if (v->size() != field.n()) v->resize(field.n());
    _projected = _projected && warm;
    _wasCold = !warm || _weightsOf != field.n();
    _weightsOf = field.n();
    int made = 0;
    if (_wasCold)
    {
        made = coldStart(field, limit, seed, pace);
        _loudest = loudness(field);
    }
    // After the last weights of a cold start only if there is time: a round has been made.
    if (!_projected && (made == 0 || pace.fits(Pace::ROUND, 1) > 0))
    {
        round(field, pace);
        ++made;
    }
    _projected = false;
    if (!_wasCold && loudness(field) < _tuning.lost * _previous)
    {
        // A jump of the object or a permutation of its points: the last phases are as good as
        // random, and improving them would take tens of updates.
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
    return weightedLevel(_weights, field.y, field.a);
}

float PhaseSearch::loudness(const FieldProblem& field) const
{
    return loudnessAt(field, naturalLevel(field));
}

void PhaseSearch::round(FieldProblem& field, Pace& pace)
{
    pace.timed(Pace::ROUND, 1, [&] { projectionRound(field, _weights); });
}

// Phases that follow a moving object drift into a poorer local optimum than they started from. A
// field that is quieter than the recent ones therefore gets further rounds, each of which raises
// the loudness.
int PhaseSearch::keepLoud(FieldProblem& field, int limit, Pace& pace)
{
    int made = 0;
    while (made < _tuning.quietRounds && loudness(field) < _tuning.quiet * _loudest &&
           made + 2 < limit && pace.fits(Pace::ROUND, 1) > 0)
    {
        reweigh(field, _weights, _tuning.mostReweighing);
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
        if (k >= _tuning.roundsBeforeWeights) reweigh(field, _weights, _tuning.mostReweighing);
    }
    return made;
}

// Tries several sets of starting phases and continues with the loudest: the phases decide the
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
        _weights = field.a;
        made += rounds(field, 0, trial, pace);
        lastStart = start;
        const float level = naturalLevel(field);
        if (start > 0 && !(level > best)) continue;
        best = level;
        bestStart = start;
        _bestWeights = _weights;
        copy(field.u, _bestU, n);
    }
    _weights = _bestWeights;
    copy(_bestU, field.u, n);
    const int more = rounds(field, trial, std::min(_tuning.coldRounds, limit), pace);
    if (more > 0 || bestStart == lastStart) return made + more;
    round(field, pace); // or q and p would be another start's
    return made + 1;
}

} // namespace midair::haptics
