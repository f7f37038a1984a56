#pragma once

#include "haptics/base/Percentile.h"
#include "haptics/base/threads/SteadyClock.h"

#include <ctime>
#include <utility>
#include <vector>

namespace midair::bench
{

/// Returns the processor time of this thread, or by another \a clock, in ms: other programs on the
/// machine don't lengthen it much.
inline double cpu_ms(clockid_t clock = CLOCK_THREAD_CPUTIME_ID)
{
    timespec now{};
    clock_gettime(clock, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

inline double cpu_us(clockid_t clock = CLOCK_THREAD_CPUTIME_ID)
{
    return 1e3 * cpu_ms(clock);
}

inline double wall_ms()
{
    return 1e3 * base::steadySeconds();
}

inline double median(std::vector<double> values)
{
    return base::percentile(std::move(values), 0.5);
}

/// Returns the median of the processor times of \a work, called so many times, in ms.
template<class Work>
double median_ms(int rounds, const Work& work)
{
    std::vector<double> times_ms;
    for (int round = 0; round < rounds; ++round)
    {
        const double start_ms = cpu_ms();
        work();
        times_ms.push_back(cpu_ms() - start_ms);
    }
    return median(std::move(times_ms));
}

} // namespace midair::bench
