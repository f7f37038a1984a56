#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace midair::bench
{

/// Returns the processor time of this thread, ms: other programs on the machine don't lengthen it
/// much.
inline double cpu_ms()
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

inline double cpu_us()
{
    return 1e3 * cpu_ms();
}

/// Returns the upper median; 0 for no values.
inline double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0 : values[values.size() / 2];
}

} // namespace midair::bench
