#include "samples/experiments/jnd/PsychometricFit.h"

#include "samples/experiments/jnd/Staircase.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace midair::samples
{

namespace
{

constexpr int kThresholds = 121;
constexpr int kSpreads = 25;

/// Answers to one value.
struct Answers
{
    int yes = 0, no = 0;
};

} // namespace

PsychometricFit fitTrials(const std::vector<Trial>& trials, const StaircaseSettings& settings)
{
    std::map<double, Answers> answers;
    for (const Trial& trial : trials)
        ++(trial.isFelt ? answers[trial.value].yes : answers[trial.value].no);
    const double least = 0.25 * settings.step;
    const double ratio = std::max(1.0, 0.25 * settings.maximum / least);
    std::vector<double> logs;
    std::vector<std::pair<double, double>> places; // threshold and the spread's logarithm
    double most = -INFINITY;
    for (int s = 0; s < kSpreads; ++s)
        for (int t = 0; t < kThresholds; ++t)
        {
            SimulatedParticipant person;
            person.lapse = kFitLapse;
            person.spread = least * std::pow(ratio, s / (kSpreads - 1.0));
            person.threshold = settings.maximum * t / (kThresholds - 1.0);
            double sum = 0.0;
            for (const auto& [value, count] : answers)
            {
                const double chance = person.chance(value);
                sum += count.yes * std::log(chance) + count.no * std::log(1.0 - chance);
            }
            logs.push_back(sum);
            places.emplace_back(person.threshold, std::log(person.spread));
            most = std::max(most, sum);
        }
    double weight = 0.0, mean = 0.0, square = 0.0, logSpread = 0.0;
    for (std::size_t k = 0; k < logs.size(); ++k)
    {
        const double w = std::exp(logs[k] - most);
        weight += w;
        mean += w * places[k].first;
        square += w * places[k].first * places[k].first;
        logSpread += w * places[k].second;
    }
    mean /= weight;
    return {mean,
            std::sqrt(std::max(0.0, square / weight - mean * mean)),
            std::exp(logSpread / weight)};
}

} // namespace midair::samples
