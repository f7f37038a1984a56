#pragma once

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

/// The threshold that a finished staircase found.
struct Threshold
{
    double value = 0.0;     ///< mean of the turns
    double deviation = 0.0; ///< of the turns, over n - 1; a measure of consistency, not an error
    int bounds = 0;         ///< turns at an end of the range
};

/// Returns the threshold of a finished staircase.
Threshold thresholdOf(const std::vector<Turn>& turns);

} // namespace midair::samples
