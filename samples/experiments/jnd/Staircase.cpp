#include "samples/experiments/jnd/Staircase.h"

#include "haptics/base/text/Range.h"

#include <cassert>
#include <cmath>

namespace midair::samples
{

namespace
{

constexpr int kMostSteps = 1000;

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
        // The run ends. Its last answers differ between here and one step back; a run that begins
        // with such an answer at the far end, as the first one may, has nothing to step back to.
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

Threshold thresholdOf(const std::vector<Turn>& turns)
{
    Threshold threshold;
    const auto count = static_cast<double>(turns.size());
    for (const Turn& turn : turns)
    {
        threshold.value += turn.value / count;
        threshold.bounds += turn.isBound ? 1 : 0;
    }
    for (const Turn& turn : turns)
        threshold.deviation += std::pow(turn.value - threshold.value, 2.0) / (count - 1.0);
    threshold.deviation = std::sqrt(threshold.deviation);
    return threshold;
}

} // namespace midair::samples
