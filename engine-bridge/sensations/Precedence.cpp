#include "engine-bridge/sensations/Precedence.h"

#include <algorithm>

namespace midair::bridge
{

void Precedence::advance(double dt_s, int highest)
{
    _highest = highest;
    for (auto& [priority, level] : _levels)
    {
        const double wanted = priority < highest ? 0.0 : 1.0;
        level += std::clamp(wanted - level, -dt_s / kFade_s, dt_s / kFade_s);
    }
}

double Precedence::level(int priority)
{
    return _levels.emplace(priority, priority < _highest ? 0.0 : 1.0).first->second;
}

bool Precedence::isFading() const
{
    return std::any_of(
        _levels.begin(), _levels.end(), [](const auto& one) { return one.second < 1.0; });
}

} // namespace midair::bridge
