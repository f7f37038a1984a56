#pragma once

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

namespace midair::bench
{

/// Processes \a snapshot in the octagon, so many times after the first, which starts from nothing,
/// each after \a change(update) has changed it; prints what the updates took. Returns the median,
/// ms.
template<class Change>
double
timeUpdates(const char* name, int updates, bridge::SceneSnapshot& snapshot, const Change& change)
{
    bridge::HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.deviceUri = "null:";
    bridge::HologramPipeline pipeline(options);
    std::vector<double> times_ms;
    double worstRms = 0.0, sumRms = 0.0;
    int changes = 0, last = 0;
    for (int i = 0; i <= updates; ++i)
    {
        snapshot.frame = static_cast<std::uint64_t>(i);
        change(i);
        const double start_ms = cpu_ms();
        const auto result = pipeline.process(snapshot);
        if (i == 0) continue;
        times_ms.push_back(cpu_ms() - start_ms);
        worstRms = std::max(worstRms, result->report().rms);
        sumRms += result->report().rms;
        changes += result->report().points != last;
        last = result->report().points;
    }
    std::printf("%-9s %4d points: median %6.2f ms, p99 %6.2f ms, longest %6.2f ms; rms %.4f %%, "
                "at worst %.4f %%; another number of points in %d of %d; sampled %d times\n",
                name,
                last,
                median(times_ms),
                base::percentile(times_ms, 0.99),
                base::percentile(times_ms, 1.0),
                100.0 * sumRms / updates,
                100.0 * worstRms,
                changes,
                updates,
                static_cast<int>(pipeline.counters().meshesSampled));
    return median(times_ms);
}

} // namespace midair::bench
