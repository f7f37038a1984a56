#include "device/recording/RunningSequence.h"

#include <cmath>

namespace midair::device::recording
{

RunningSequence::RunningSequence(const DriveSequence& sequence, std::uint64_t start_ns) :
    _sequence(sequence),
    _start_ns(start_ns)
{
}

std::uint64_t RunningSequence::time_ns(std::uint64_t step) const
{
    const double passed_ns = static_cast<double>(step) * (1e9 / _sequence.rate_Hz);
    return _start_ns + static_cast<std::uint64_t>(std::llround(passed_ns));
}

const DriveSignal& RunningSequence::signal(std::uint64_t step) const
{
    return _sequence.signals[static_cast<std::size_t>(step % _sequence.signals.size())];
}

std::uint64_t RunningSequence::begun(std::uint64_t time_ns) const
{
    const double passed_s = static_cast<double>(time_ns - _start_ns) * 1e-9;
    std::uint64_t steps = static_cast<std::uint64_t>(passed_s * _sequence.rate_Hz) + 1;
    // The product may be rounded past a step's start, either way.
    while (this->time_ns(steps) <= time_ns)
        ++steps;
    while (steps > 1 && this->time_ns(steps - 1) > time_ns)
        --steps;
    return steps;
}

std::uint64_t RunningSequence::leaveOutLate(std::uint64_t time_ns)
{
    const std::uint64_t steps = begun(time_ns);
    const auto most = static_cast<std::uint64_t>(kMostBacklog_s * _sequence.rate_Hz) + 1;
    if (steps <= _next + most) return 0;
    const std::uint64_t late = steps - most - _next;
    _next += late;
    return late;
}

} // namespace midair::device::recording
