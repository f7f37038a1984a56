#include "engine-bridge/hands/HandSource.h"

#include "haptics/base/threads/Mutex.h"

#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

void InjectedHandSource::set(const HandFrame& frame)
{
    const base::Lock lock(_mutex);
    _frame = frame;
    ++_set;
}

void InjectedHandSource::clear()
{
    const base::Lock lock(_mutex);
    _frame.hands.clear();
}

bool InjectedHandSource::frameAt(double time_s, HandFrame& frame)
{
    const base::Lock lock(_mutex);
    frame.time_s = time_s;
    frame.hands.clear();
    if (_frame.hands.empty() || !(std::abs(time_s - _frame.time_s) <= _staleAfter_s)) return false;
    frame = _frame;
    return true;
}

std::string InjectedHandSource::status() const
{
    const base::Lock lock(_mutex);
    return fmt::format("hands set by the application, {} frames so far", _set);
}

} // namespace midair::bridge
