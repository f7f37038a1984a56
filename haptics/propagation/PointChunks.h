#pragma once

#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace midair::haptics
{

/// Distributes points in chunks to worker threads.
class PointChunks
{
public:
    static constexpr Eigen::Index kAtOnce = 8; ///< points in a chunk; the last may have fewer

    PointChunks(Eigen::Index points, const base::StopToken& stop) : _points(points), _stop(stop) {}

    /// Takes the next chunk: points \a begin .. \a begin + \a count - 1. Returns false if none is
    /// left or a stop is requested. Any thread.
    bool take(Eigen::Index& begin, Eigen::Index& count)
    {
        if (_stop.requested()) return false;
        begin = _next.fetch_add(kAtOnce);
        count = std::min(kAtOnce, _points - begin);
        return count > 0;
    }

    /// Calls \a work, which takes chunks until none are left, on up to \a threads threads including
    /// this one. Throws base::Stopped if a stop was requested.
    template<typename Work>
    void run(int threads, const Work& work)
    {
        const Eigen::Index chunks = (_points + kAtOnce - 1) / kAtOnce;
        std::vector<std::thread> helpers;
        for (Eigen::Index t = 1; t < std::min<Eigen::Index>(threads, chunks); ++t)
            helpers.emplace_back(work);
        work();
        for (std::thread& helper : helpers)
            helper.join();
        _stop.throwIfRequested();
    }

private:
    const Eigen::Index _points;
    const base::StopToken& _stop;
    std::atomic<Eigen::Index> _next{0};
};

} // namespace midair::haptics
