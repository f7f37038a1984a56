#include "haptics/solvers/production/LouderPhases.h"

#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "Louder at rest".
constexpr float kKicked = 0.35f;        // share of the points whose phases are turned
constexpr int kTrialRounds = 60;        // rounds of a trial
constexpr int kMostTrials = 100;        // for few points
constexpr double kTrialEntries = 2.4e6; // rounds times points of all trials
constexpr int kLeastTrials = 10;        // for many points
constexpr int kRoundsInStep = 4000;     // rounds times points of a step
constexpr double kLeastShareOfWay = 1e-5;
constexpr double kMostLonger = 1.5;             // largest growth of a step
constexpr double kShortShareOfWay = 1.0 / 1000; // shorter steps only after one that is not kept

// A number in 0 .. 1, the same with any standard library.
float drawnNumber(std::mt19937_64& random)
{
    return static_cast<float>(random() >> 40) * 0x1p-24f;
}

std::complex<float> directionOf(std::complex<float> c)
{
    const float size = std::abs(c);
    return size > 0.0f ? c / size : std::complex<float>(1.0f);
}

} // namespace

LouderPhases::LouderPhases(const SolverOptions& options) :
    _field(options.pool ? options.pool : std::make_shared<base::ThreadPool>(options.threads),
           Storage::FIXED,
           options.stop),
    _search(_tuning),
    _seed(options.seed)
{
}

void LouderPhases::begin(const ControlPoints& points,
                         const TransducerArray& array,
                         const Medium& medium,
                         const Eigen::VectorXcf& c)
{
    end();
    _given = _loudest = 0.0f;
    _isBuilt = false;
    _best = c;
    _active.clear();
    for (Eigen::Index l = 0; l < c.size(); ++l)
        if (c[l] != 0.0f) _active.push_back(static_cast<int>(l));
    if (c.size() != points.size() || _active.size() < 2 || points.size() > kMostPoints) return;
    _field.forget();
    _field.assign(points, _active, array, medium, 0.0);
    _field.a /= _field.a.maxCoeff();
    raiseTargets(_field.a);
    _random.seed(_seed);
    _trials = std::clamp(
        static_cast<int>(kTrialEntries / kTrialRounds / static_cast<double>(_active.size())),
        kLeastTrials,
        kMostTrials);
    _rounds = kTrialRounds;
}

void LouderPhases::step()
{
    if (!hasWork()) return;
    _field.start();
    _pace.start(_field, 0.0);
    if (!_isBuilt)
    {
        _field.build();
        for (std::size_t l = 0; l < _active.size(); ++l)
            _field.u.set(l, directionOf(_best[_active[l]]));
        _search.begin(_field);
        kick();
        _search.improve(_field, 0, _pace);
        _given = _loudest = _search.naturalLevel(_field);
        _isBuilt = true;
        return;
    }
    const int count =
        std::clamp(kRoundsInStep / static_cast<int>(_active.size()), 1, std::max(_rounds, 1));
    _search.improve(_field, count, _pace);
    _rounds -= count;
    if (_rounds > 0) return;
    judge();
    _rounds = kTrialRounds;
    --_trials;
    kick();
}

void LouderPhases::judge()
{
    const float level = _search.naturalLevel(_field);
    if (!(level > _loudest)) return;
    _loudest = level;
    const Eigen::VectorXcf c = _search.multipliers(_field);
    for (std::size_t l = 0; l < _active.size(); ++l)
        _best[_active[l]] = c[static_cast<Eigen::Index>(l)];
}

// Starts the next trial. The first and the last one only make rounds from the best field.
void LouderPhases::kick()
{
    const bool turns = _isBuilt && _trials > 1;
    Eigen::VectorXcf c(_field.n());
    for (Eigen::Index l = 0; l < c.size(); ++l)
    {
        c[l] = _best[_active[static_cast<std::size_t>(l)]];
        if (turns && drawnNumber(_random) < kKicked)
            c[l] =
                std::polar(std::abs(c[l]), static_cast<float>(base::kTwoPi) * drawnNumber(_random));
    }
    _search.take(_field, c);
}

PhaseWalk::PhaseWalk(const Eigen::VectorXcf& from, const Eigen::VectorXcf& to)
{
    const float size = from.cwiseAbs().sum(), other = to.cwiseAbs().sum();
    const bool isBoth = size > 0.0f && other > 0.0f;
    const std::complex<float> turn =
        isBoth ? (size / other) * std::conj(directionOf(from.dot(to))) : 1.0f;
    begin(from, turn * to, Steps());
}

void PhaseWalk::begin(const Eigen::VectorXcf& from, const Eigen::VectorXcf& to, const Steps& steps)
{
    _from = from;
    _to = to;
    _at = 0.0;
    _step = steps.first;
    _meant = steps.meant;
}

Eigen::VectorXcf PhaseWalk::next() const
{
    if (_at + _step >= 1.0) return _to;
    const auto share = static_cast<float>(_at + _step);
    Eigen::VectorXcf c(_from.size());
    for (Eigen::Index l = 0; l < c.size(); ++l)
    {
        const float size = std::abs(_from[l]) + share * (std::abs(_to[l]) - std::abs(_from[l]));
        const float turn_rad = std::arg(directionOf(_to[l]) * std::conj(directionOf(_from[l])));
        c[l] = size * directionOf(_from[l]) * std::polar(1.0f, share * turn_rad);
    }
    return c;
}

bool PhaseWalk::accept(double turn_rad, double jump)
{
    const double used = std::max(turn_rad / kMostTurn_rad, (jump - 1.0) / (kMostJump - 1.0));
    if (!(used <= 1.0)) // also for NaN
    {
        _step *= 0.5;
        if (_step < kLeastShareOfWay) end();
        return false;
    }
    _at = std::min(_at + _step, 1.0);
    _step =
        std::max(_step * std::min(kMostLonger, _meant / std::max(used, 1e-3)), kShortShareOfWay);
    return true;
}

} // namespace midair::haptics
