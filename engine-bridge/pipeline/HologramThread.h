#pragma once

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/threads/LatestSlot.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace midair::bridge
{

/// Runs a HologramPipeline in the background: snapshots in, the newest wins, results out; no frame
/// ever waits. While no snapshot comes the pipeline looks after its device.
///
/// submit() and the readers may be called from any one thread each while the pipeline works. The
/// pipeline is made in the thread when the first snapshot comes (opening a device may take a
/// while), and gone, the device silent, when the destructor returns. What is being solved then is
/// broken off, which takes some milliseconds; a solver of the application's own is waited for
/// unless it looks at SolverOptions::stop, but the device is silent before.
class HologramThread
{
public:
    using PipelineFactory = std::function<std::unique_ptr<HologramPipeline>()>;

    explicit HologramThread(HologramOptions options);
    explicit HologramThread(PipelineFactory makePipeline);
    ~HologramThread();

    HologramThread(const HologramThread&) = delete;
    HologramThread& operator=(const HologramThread&) = delete;

    /// Replaces the pipeline before the next snapshot is processed: the old one is gone, its device
    /// closed, before \a makePipeline runs; where that gives none, nothing is played until the
    /// next. What it throws becomes a result that is REFUSED, with the message. Doesn't wait; what
    /// is being solved is broken off, and STOPPED.
    void setPipeline(PipelineFactory makePipeline);

    /// Hands \a snapshot over and leaves an old one in its place, whose memory the caller may
    /// refill. Never waits for the pipeline, allocates nothing. One without objects silences the
    /// device at once, whatever is being solved, which is broken off and not played.
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
    void setAtWork(HologramPipeline* pipeline);
    void silenceNow();
    /// No pipeline, so no device: \a why, where that is somebody's fault.
    void publishClosed(haptics::StopReason stop, const std::string& why);
    void publish(std::shared_ptr<const HologramResult> result, const HologramCounters& counters);

    base::LatestSlot<SceneSnapshot> _slot;
    mutable std::mutex _mutex;    ///< of what follows; held for a copy at most
    PipelineFactory _newPipeline; ///< empty: keep the one at work
    std::shared_ptr<const HologramResult> _result;
    std::atomic<std::uint64_t> _results{0};
    HologramCounters _counters;
    std::atomic<double> _restWorkSince_s{0.0}; ///< steady clock; 0: none is under way
    base::StopSource _stop;                    ///< asked for, and cleared, under the slot's lock
    std::mutex _atWorkMutex; ///< of what follows; held while a device falls silent
    HologramPipeline* _atWork = nullptr;
    std::thread _thread; ///< last: starts when all else is there
};

} // namespace midair::bridge
