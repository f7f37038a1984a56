#include "device/autd3/emulator/unit/UnitSilencer.h"

#include <algorithm>
#include <cmath>

namespace midair::device::emulation
{

namespace
{

// The turn of level that is nearest to value.
float nearestTurn(float level, float value)
{
    return level + 256.0F * std::round((value - level) / 256.0F);
}

} // namespace

void UnitSilencer::Gliding::headFor(float next, int steps)
{
    if (next == target) return;
    target = next;
    step = (target - value) / static_cast<float>(steps);
    left = steps;
}

void UnitSilencer::Gliding::pass(Time_ns periods, bool byRate, float rate)
{
    if (value == target) return;
    if (byRate)
    {
        const float way = rate * static_cast<float>(periods);
        value = value < target ? std::min(target, value + way) : std::max(target, value - way);
        return;
    }
    const Time_ns passed = std::min<Time_ns>(periods, left);
    left -= static_cast<int>(passed);
    value = left == 0 ? target : value + step * static_cast<float>(passed);
}

void UnitSilencer::head(const UnitPattern& target)
{
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        Gliding& phase = _phase[i];
        // Where it is going already, it goes on: another turn of the same level is no other target.
        if (phase.target - 256.0F * std::floor(phase.target / 256.0F) != float(target.phase[i]))
            phase.headFor(nearestTurn(target.phase[i], phase.value), _settings.stepsPhase);
        _intensity[i].headFor(target.intensity[i], _settings.stepsIntensity);
    }
}

void UnitSilencer::jump(const UnitPattern& target)
{
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        _phase[i] = {float(target.phase[i]), float(target.phase[i]), 0, 0};
        _intensity[i] = {float(target.intensity[i]), float(target.intensity[i]), 0, 0};
    }
}

void UnitSilencer::glide(Time_ns periods)
{
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        Gliding& phase = _phase[i];
        phase.pass(periods, _settings.byRate, _settings.ratePhase / 256.0F);
        const float turns = 256.0F * std::floor(phase.value / 256.0F); // so that none winds up
        phase.value -= turns;
        phase.target -= turns;
        _intensity[i].pass(periods, _settings.byRate, _settings.rateIntensity / 256.0F);
    }
}

} // namespace midair::device::emulation
