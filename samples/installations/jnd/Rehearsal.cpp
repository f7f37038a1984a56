#include "samples/installations/jnd/Rehearsal.h"

#include "samples/installations/jnd/PsychometricFit.h"

#include <cmath>
#include <vector>

namespace midair::samples
{

namespace
{

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
