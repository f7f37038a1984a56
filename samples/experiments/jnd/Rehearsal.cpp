#include "samples/experiments/jnd/Rehearsal.h"

#include "haptics/base/text/Range.h"
#include "samples/experiments/jnd/PsychometricFit.h"

#include <cmath>
#include <random>
#include <vector>

namespace midair::samples
{

namespace
{

double normalDistribution(double x)
{
    return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

Recovery recoveryOf(const std::vector<double>& errors, double spread)
{
    Recovery recovery;
    const auto count = static_cast<double>(errors.size());
    for (const double error : errors)
    {
        recovery.bias += error / count;
        recovery.within += std::abs(error) <= spread ? 1.0 / count : 0.0;
    }
    for (const double error : errors)
        recovery.deviation += std::pow(error - recovery.bias, 2.0) / (count - 1.0);
    recovery.deviation = std::sqrt(recovery.deviation);
    recovery.biasError = recovery.deviation / std::sqrt(count);
    return recovery;
}

} // namespace

double SimulatedParticipant::chance(double value) const
{
    return 0.5 * lapse + (1.0 - lapse) * normalDistribution((value - threshold) / spread);
}

bool SimulatedParticipant::feels(int trial, double value) const
{
    // A generator for each trial: std::seed_seq spreads neighbouring seeds, and both are the same
    // with every standard library.
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
