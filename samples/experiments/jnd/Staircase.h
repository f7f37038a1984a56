#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace midair::samples
{

/// Parameters of a staircase.
struct StaircaseSettings
{
    double maximum = 45.0; ///< first value, > 0
    double step = 2.5;     ///< > 0; maximum is a multiple of it, at most 1000 steps
    int times = 3;         ///< 1 .. 100: number of downward runs, and of upward runs
};

/// Returns what is wrong with \a settings, or an empty text.
std::string problemOf(const StaircaseSettings& settings);

/// End of a run.
struct Turn
{
    double value = 0.0;   ///< midway between the two answers that differ
    bool isBound = false; ///< at an end of the range, where no answer can differ
};

/// One-up one-down staircase: starts at the maximum, goes down by a step while the difference is
/// felt, then up until it is felt again, and so on, as often as the settings say. A run that would
/// leave the range repeats its last value and turns there after kPatience such answers. That counts
/// as a bound: the threshold may be outside.
class Staircase
{
public:
    /// \a settings must be valid.
    explicit Staircase(const StaircaseSettings& settings);

    double value() const { return _level * _settings.step; }        ///< of the next trial
    int run() const { return static_cast<int>(_turns.size()) + 1; } ///< of the next trial, from 1
    bool isDown() const { return _turns.size() % 2 == 0; }
    bool isFinished() const;
    int trials() const { return _trials; } ///< answered so far

    /// Adds the answer to value(): whether the difference is felt. Must not be finished.
    void answer(bool isFelt);

    const std::vector<Turn>& turns() const { return _turns; }

    static constexpr int kPatience = 3;

private:
    void turn(double level, bool isBound);

    StaircaseSettings _settings;
    int _top = 0;   ///< highest level
    int _level = 0; ///< of the next trial, in steps
    int _atEnd = 0; ///< consecutive answers that would leave the range
    int _trials = 0;
    std::vector<Turn> _turns;
};

/// Mean and standard deviation (over n - 1; 0 for one) of at least one value.
struct Spread
{
    explicit Spread(const std::vector<double>& values);

    double mean = 0.0, deviation = 0.0;
};

/// The threshold of a finished staircase.
struct Threshold
{
    double value = 0.0;     ///< mean of the turns
    double deviation = 0.0; ///< of the turns, over n - 1; a measure of consistency, not an error
    int bounds = 0;         ///< turns at an end of the range
};

/// Returns the threshold of a finished staircase.
Threshold thresholdOf(const std::vector<Turn>& turns);

/// A simulated participant with a known threshold, to test the procedure. Feels a difference x with
/// probability
///     lapse/2 + (1 - lapse) Phi((x - threshold)/spread),
/// Phi being the normal distribution, so x = threshold is felt in half of all trials.
struct SimulatedParticipant
{
    double threshold = 0.0;
    double spread = 1.0; ///< > 0, standard deviation of Phi; its slope is 1/(spread sqrt(2 pi))
    double lapse = 0.02; ///< 0 .. 1: share of random answers
    std::uint64_t seed = 1;

    double chance(double value) const;

    /// Returns the answer in trial \a trial, from 1. It depends only on the arguments and members,
    /// so a run that continues after a kill has the same answers.
    bool feels(int trial, double value) const;
};

/// Returns what is wrong with \a participant, or an empty text.
std::string problemOf(const SimulatedParticipant& participant);

/// How well a known threshold is recovered.
struct Recovery
{
    double bias = 0.0;      ///< mean of found minus true thresholds
    double biasError = 0.0; ///< standard error of that mean
    double deviation = 0.0; ///< standard deviation of the found thresholds, over n - 1
    double within = 0.0;    ///< share of sessions with an error of at most the participant's spread
};

/// Results of many sessions with simulated participants.
struct Rehearsal
{
    Recovery fit;         ///< by PsychometricFit
    Recovery turns;       ///< by the mean of the turns
    double covered = 0.0; ///< share of sessions with an error of at most 1.96 thresholdError
    double bounded = 0.0; ///< share with a turn at an end of the range; these sessions are included
    double trials = 0.0;  ///< mean number per session
};

/// Runs \a participant through \a sessions, > 1, without fields, with its seed and the following
/// ones.
Rehearsal
rehearse(SimulatedParticipant participant, const StaircaseSettings& settings, int sessions);

} // namespace midair::samples
