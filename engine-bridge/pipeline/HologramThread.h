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

/// Runs a HologramPipeline in a thread: takes the newest snapshot, publishes its result, and never
/// makes a frame wait. While no snapshot comes, it calls HologramPipeline::attend().
///
/// submit() and the readers may be called from any one thread each. The pipeline is made in its
/// thread when the first snapshot comes, since opening a device may take a while. The destructor
/// silences the device and breaks off the solve under way, which takes some milliseconds; it waits
/// for an application's own solver that doesn't check SolverOptions::stop.
class HologramThread
{
public:
    using PipelineFactory = std::function<std::unique_ptr<HologramPipeline>()>;

    /// Starts the thread, in which a pipeline with \a options is made.
    explicit HologramThread(HologramOptions options);
    /// Starts the thread; \a makePipeline as for setPipeline().
    explicit HologramThread(PipelineFactory makePipeline);
    ~HologramThread();

    HologramThread(const HologramThread&) = delete;
    HologramThread& operator=(const HologramThread&) = delete;

    /// Replaces the pipeline before the next snapshot is processed. The old one is destroyed, its
    /// device closed, before \a makePipeline runs in the pipeline's thread. If \a makePipeline
    /// returns null, nothing is played until the next setPipeline(); if it throws, the result says
    /// REFUSED, with the message. Doesn't wait; a solve under way is broken off, its result says
    /// STOPPED.
    void setPipeline(PipelineFactory makePipeline);

    /// Hands \a snapshot over and leaves an old one in its place, whose memory the caller may
    /// refill. Never waits for a solve, allocates nothing. A snapshot without objects silences the
    /// device at once and breaks off the solve under way, which is not played.
    void submit(SceneSnapshot& snapshot);

    /// The newest result; null until the first snapshot was processed.
    std::shared_ptr<const HologramResult> latestResult() const;

    /// The number of results published so far; a skipped snapshot publishes the last one again.
    std::uint64_t results() const { return _results; }

    /// The pipeline's counters as of the last processed snapshot; newer than the result's own if
    /// that snapshot was skipped.
    HologramCounters counters() const;

private:
    void run();
    void makePipeline(std::unique_ptr<HologramPipeline>& pipeline);
    void setAtWork(HologramPipeline* pipeline);
    void silenceNow();
    /// Publishes a result without fields, for there is no pipeline; \a why: the error, empty if
    /// there is none.
    void publishClosed(haptics::StopReason stop, const std::string& why);
    void publish(std::shared_ptr<const HologramResult> result, const HologramCounters& counters);

    base::LatestSlot<SceneSnapshot> _slot;
    mutable std::mutex _mutex;    ///< guards the members up to _counters; held for a copy at most
    PipelineFactory _newPipeline; ///< empty: the current pipeline stays
    std::shared_ptr<const HologramResult> _result;
    std::atomic<std::uint64_t> _results{0};
    HologramCounters _counters;
    std::atomic<double> _restWorkSince_s{0.0}; ///< start of attend(), steady clock; 0: not running
    base::StopSource _stop;                    ///< requested and cleared under the slot's lock
    std::mutex _atWorkMutex;                   ///< guards _atWork; held while a device falls silent
    HologramPipeline* _atWork = nullptr;
    std::thread _thread; ///< last: it uses all other members
};

} // namespace midair::bridge
