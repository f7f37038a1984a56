#include "samples/experiments/jnd/Staircase.h"

#include "haptics/base/text/Range.h"
#include "samples/experiments/jnd/TrialFile.h"

#include <Eigen/Core>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

namespace midair::samples
{

namespace
{

constexpr int kMostSteps = 1000;

double normalDistribution(double x)
{
    return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

Recovery recoveryOf(const std::vector<double>& errors, double spread)
{
    const auto count = static_cast<double>(errors.size());
    const Spread found(errors);
    const auto isWithin = [spread](double error) { return std::abs(error) <= spread; };
    const auto within = std::count_if(errors.begin(), errors.end(), isWithin);
    return {found.mean,
            found.deviation / std::sqrt(count),
            found.deviation,
            static_cast<double>(within) / count};
}

} // namespace

std::string problemOf(const StaircaseSettings& settings)
{
    std::string problem;
    const double steps = settings.maximum / settings.step;
    base::RangeCheck("the staircase's ")
        .above("maximum", settings.maximum, 0.0)
        .above("step", settings.step, 0.0)
        .within("times", settings.times, 1.0, 100.0)
        .check(std::abs(steps - std::round(steps)) < 1e-9 && steps < kMostSteps + 0.5,
               "step",
               settings.step,
               "a whole part of its maximum, at most 1000 of them")
        .passed(&problem);
    return problem;
}

Staircase::Staircase(const StaircaseSettings& settings) :
    _settings(settings),
    _top(static_cast<int>(std::lround(settings.maximum / settings.step))),
    _level(_top)
{
    assert(problemOf(settings).empty());
}

bool Staircase::isFinished() const
{
    return static_cast<int>(_turns.size()) >= 2 * _settings.times;
}

void Staircase::turn(double level, bool isBound)
{
    _turns.push_back({level * _settings.step, isBound});
    _atEnd = 0;
}

void Staircase::answer(bool isFelt)
{
    assert(!isFinished());
    ++_trials;
    const int end = isDown() ? 0 : _top;
    const int way = isDown() ? -1 : 1;
    if (isFelt != isDown())
    {
        // Ends the run. Its last answers differ between this value and one step back; a run that
        // begins with such an answer at the far end, as the first one may, has no previous step.
        const int back = _level - way;
        const bool isBound = back < 0 || back > _top;
        turn(isBound ? _level : 0.5 * (_level + back), isBound);
        _level = isBound ? _level : back;
        return;
    }
    if (_level != end)
    {
        _level += way;
        return;
    }
    if (++_atEnd < kPatience) return;
    turn(_level, true);
}

Spread::Spread(const std::vector<double>& values)
{
    const Eigen::Map<const Eigen::ArrayXd> all(values.data(),
                                               static_cast<Eigen::Index>(values.size()));
    mean = all.mean();
    deviation = std::sqrt((all - mean).square().sum() / std::max<double>(1.0, all.size() - 1.0));
}

Threshold thresholdOf(const std::vector<Turn>& turns)
{
    if (turns.empty()) return {};
    std::vector<double> values;
    int bounds = 0;
    for (const Turn& turn : turns)
    {
        values.push_back(turn.value);
        bounds += turn.isBound ? 1 : 0;
    }
    const Spread spread(values);
    return {spread.mean, spread.deviation, bounds};
}

double SimulatedParticipant::chance(double value) const
{
    return 0.5 * lapse + (1.0 - lapse) * normalDistribution((value - threshold) / spread);
}

bool SimulatedParticipant::feels(int trial, double value) const
{
    // A generator for each trial: std::seed_seq decorrelates neighbouring seeds, and both give
    // equal results with every standard library.
    std::seed_seq mix{static_cast<std::uint32_t>(seed),
                      static_cast<std::uint32_t>(seed >> 32U),
                      static_cast<std::uint32_t>(trial)};
    std::mt19937_64 random(mix);
    return static_cast<double>(random() >> 11U) * 0x1p-53 < chance(value);
}

std::string problemOf(const SimulatedParticipant& participant)
{
    std::string problem;
    base::RangeCheck("the simulated participant's ")
        .atLeast("threshold", participant.threshold, 0.0)
        .above("spread", participant.spread, 0.0)
        .within("lapse", participant.lapse, 0.0, 1.0)
        .passed(&problem);
    return problem;
}

Rehearsal
rehearse(SimulatedParticipant participant, const StaircaseSettings& settings, int sessions)
{
    Rehearsal rehearsal;
    std::vector<double> fitErrors, turnErrors;
    for (int session = 0; session < sessions; ++session, ++participant.seed)
    {
        Staircase staircase(settings);
        std::vector<Trial> trials;
        while (!staircase.isFinished())
        {
            Trial trial;
            trial.value = staircase.value();
            trial.isFelt = participant.feels(staircase.trials() + 1, trial.value);
            staircase.answer(trial.isFelt);
            trials.push_back(trial);
        }
        const Threshold threshold = thresholdOf(staircase.turns());
        const PsychometricFit fit = fitTrials(trials, settings);
        turnErrors.push_back(threshold.value - participant.threshold);
        fitErrors.push_back(fit.threshold - participant.threshold);
        const bool isCovered = std::abs(fitErrors.back()) <= 1.96 * fit.thresholdError;
        rehearsal.covered += isCovered ? 1.0 / sessions : 0.0;
        rehearsal.bounded += threshold.bounds > 0 ? 1.0 / sessions : 0.0;
        rehearsal.trials += static_cast<double>(trials.size()) / sessions;
    }
    rehearsal.fit = recoveryOf(fitErrors, participant.spread);
    rehearsal.turns = recoveryOf(turnErrors, participant.spread);
    return rehearsal;
}

} // namespace midair::samples
