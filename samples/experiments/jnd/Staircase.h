#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace midair::samples
{

/// How a staircase goes.
struct StaircaseSettings
{
    double maximum = 45.0; ///< first value, > 0
    double step = 2.5;     ///< > 0; maximum is a multiple of it, at most 1000 steps
    int times = 3;         ///< 1 .. 100: runs down, and as many up
};

/// Returns what is wrong with \a settings, as a sentence; empty: nothing.
std::string problemOf(const StaircaseSettings& settings);

/// Where a run ended.
struct Turn
{
    double value = 0.0;   ///< in the middle between the two answers that differ
    bool isBound = false; ///< at an end of the range, where no second answer could differ
};

/// One up, one down: begins at the maximum and goes down by a step as long as the difference is
/// felt, then up until it is felt again, and so on, each as often as settings say. A run that would
/// leave the range asks again at its end and turns there after kPatience such answers, which
/// counts as bound: the threshold may lie outside.
class Staircase
{
public:
    /// Settings without a problem.
    explicit Staircase(const StaircaseSettings& settings);

    double value() const { return _level * _settings.step; }        ///< of the next trial
    int run() const { return static_cast<int>(_turns.size()) + 1; } ///< of the next trial, from 1
    bool isDown() const { return _turns.size() % 2 == 0; }
    bool isFinished() const;
    int trials() const { return _trials; } ///< answered so far

    /// Takes the answer to value(): whether the difference is felt. Not when finished.
    void answer(bool isFelt);

    const std::vector<Turn>& turns() const { return _turns; }

    static constexpr int kPatience = 3;

private:
    void turn(double level, bool isBound);

    StaircaseSettings _settings;
    int _top = 0;   ///< highest level
    int _level = 0; ///< of the next trial, in steps
    int _atEnd = 0; ///< answers in a row that would leave the range
    int _trials = 0;
    std::vector<Turn> _turns;
};

/// Mean and standard deviation (over n - 1; 0 for one) of values, of which there is at least one.
struct Spread
{
    explicit Spread(const std::vector<double>& values);

    double mean = 0.0, deviation = 0.0;
};

/// The threshold that a finished staircase found.
struct Threshold
{
    double value = 0.0;     ///< mean of the turns
    double deviation = 0.0; ///< of the turns, over n - 1; a measure of consistency, not an error
    int bounds = 0;         ///< turns at an end of the range
};

/// Returns the threshold of a finished staircase.
Threshold thresholdOf(const std::vector<Turn>& turns);

/// Somebody whose threshold is known, to try the procedure: feels a difference x with probability
///     lapse/2 + (1 - lapse) Phi((x - threshold)/spread),
/// Phi the normal distribution, so that x = threshold is felt in half of all trials.
struct SimulatedParticipant
{
    double threshold = 0.0;
    double spread = 1.0; ///< > 0, standard deviation of Phi; its slope is 1/(spread sqrt(2 pi))
    double lapse = 0.02; ///< 0 .. 1: share of trials that are answered by a coin
    std::uint64_t seed = 1;

    double chance(double value) const;

    /// Returns the answer in trial \a trial, from 1. It depends on what is given here alone, so a
    /// run that goes on after it was killed has the answers of one that wasn't.
    bool feels(int trial, double value) const;
};

/// Returns what is wrong with it, as a sentence; empty: nothing.
std::string problemOf(const SimulatedParticipant& participant);

/// How well a threshold that is known is found.
struct Recovery
{
    double bias = 0.0;      ///< mean of found less true
    double biasError = 0.0; ///< standard error of that mean
    double deviation = 0.0; ///< standard deviation of what is found, over n - 1
    double within = 0.0;    ///< share of sessions that are off by at most the participant's spread
};

/// What came of many sessions with simulated participants.
struct Rehearsal
{
    Recovery fit;         ///< by PsychometricFit
    Recovery turns;       ///< by the mean of the turns
    double covered = 0.0; ///< share of sessions that are off by at most 1.96 thresholdError
    double bounded = 0.0; ///< share with a turn at an end of the range, which count as the others
    double trials = 0.0;  ///< mean number in a session
};

/// Leads \a participant through \a sessions, > 1, without fields, with its seed and those that
/// follow it.
Rehearsal
rehearse(SimulatedParticipant participant, const StaircaseSettings& settings, int sessions);

} // namespace midair::samples
