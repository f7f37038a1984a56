#pragma once

#include "engine-bridge/HologramPipeline.h"
#include "engine-bridge/LatestSlot.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace midair::bridge
{

/// Runs a HologramPipeline in the background: snapshots in, the newest wins, results out; no frame ever waits. While no
/// snapshot comes the pipeline looks after its device.
///
/// submit() and the readers may be called from any one thread each while the pipeline works. The pipeline is made in the
/// thread when the first snapshot comes (opening a device may take a while), and gone, the device silent, when the destructor returns: that waits for
/// the solve at hand, since a solver can't be broken off, and for no other.
class HologramThread
{
public:
    using PipelineFactory = std::function<std::unique_ptr<HologramPipeline>()>;

    explicit HologramThread(HologramOptions options);
    explicit HologramThread(PipelineFactory makePipeline);
    ~HologramThread();

    HologramThread(const HologramThread&) = delete;
    HologramThread& operator=(const HologramThread&) = delete;

    /// Replaces the pipeline before the next snapshot is processed: the old one is gone, its device closed, before
    /// \a makePipeline runs; where that gives none, nothing is played until the next. What it throws becomes a result that is REFUSED, with the message. Doesn't wait.
    void setPipeline(PipelineFactory makePipeline);

    /// Hands \a snapshot over and leaves an old one in its place, whose memory the caller may refill. Never waits for the
    /// pipeline, allocates nothing.
    void submit(SceneSnapshot& snapshot);

    /// Null until the first snapshot is through.
    std::shared_ptr<const HologramResult> latestResult() const;

    /// How many results there have been: a look whether latestResult() is a new one.
    std::uint64_t results() const { return _results; }

    /// Up to date also where a snapshot was skipped and there is no new result.
    HologramCounters counters() const;

private:
    void run();
    void makePipeline(std::unique_ptr<HologramPipeline>& pipeline);
    void publish(std::shared_ptr<const HologramResult> result, const HologramCounters& counters);

    LatestSlot<SceneSnapshot> _slot;
    mutable std::mutex _mutex;    ///< of what follows; held for a copy at most
    PipelineFactory _newPipeline; ///< empty: keep the one at work
    std::shared_ptr<const HologramResult> _result;
    std::atomic<std::uint64_t> _results{0};
    HologramCounters _counters;
    std::thread _thread; ///< last: starts when all else is there
};

} // namespace midair::bridge
