#pragma once

#include "device/limits/Lead.h"
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/threads/LatestSlot.h"
#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Runs a HologramPipeline in a thread: takes the newest snapshot, publishes its result, and never
/// makes a frame wait. While no snapshot comes, it calls HologramPipeline::attend().
///
/// submit() belongs to one thread, and so do setPipeline() and setOptions(). The pipeline is made
/// in its thread when the first snapshot comes, since opening a device may take a while. The
/// destructor silences the device and breaks off the solve under way, which takes some
/// milliseconds; it waits for an application's own solver that doesn't check SolverOptions::stop.
class HologramThread
{
public:
    using PipelineFactory = std::function<std::unique_ptr<HologramPipeline>()>;
    /// Returns true if a pipeline that was made, or failed to, should be made anew: a file that it
    /// was made from has changed. Called between snapshots, so it has to be cheap.
    using StaleCheck = std::function<bool()>;

    /// Starts the thread, in which a pipeline with \a options is made.
    explicit HologramThread(HologramOptions options);
    /// Starts the thread; \a makePipeline as for setPipeline(). \a lead, which isn't null, leads
    /// all its pipelines; making this object is a sign of life.
    explicit HologramThread(PipelineFactory makePipeline,
                            StaleCheck isStale = {},
                            std::shared_ptr<device::Lead> lead = std::make_shared<device::Lead>());
    ~HologramThread();

    HologramThread(const HologramThread&) = delete;
    HologramThread& operator=(const HologramThread&) = delete;

    /// Replaces the pipeline before the next snapshot is processed. The old one is destroyed, its
    /// device closed, before \a makePipeline runs in the pipeline's thread. If \a makePipeline
    /// returns null, nothing is played until the next setPipeline(); if it throws, the result says
    /// REFUSED, with the message. Doesn't wait; a solve under way is broken off, its result says
    /// STOPPED. When \a isStale, called in the same thread, says so, \a makePipeline runs again and
    /// the last snapshot is processed again.
    void setPipeline(PipelineFactory makePipeline, StaleCheck isStale = {});

    /// Gives the pipeline other options before the next snapshot is processed, with its device
    /// still open (HologramPipeline::reconfigure()); a snapshot has to follow. A solve under way
    /// goes on. But a stricter cap holds at once: a lower amplitude for what is played already, a
    /// lower pressure by silence until the next snapshot is processed. \a otherwise makes a
    /// pipeline with these options, as for setPipeline(): now if there is none, else when isStale
    /// says so.
    void setOptions(HologramOptions options, PipelineFactory otherwise);

    /// Silences the array at once, and keeps it silent with its device open until setMuted(false),
    /// which plays the newest field again. Any thread.
    void setMuted(bool muted);

    /// Silences the array at once, and breaks off the solve under way, whose field is not played;
    /// the next snapshot is played again. Any thread.
    void silence();

    /// To be called with each frame, changed or not: a device with a hold (SafetyLimits::hold_s)
    /// falls silent when nobody calls it, or submit(), for that time. Nothing else is a sign of
    /// life: no field, no result, no reader. Never waits for the device. Any thread.
    void keepAlive() { _lead->keepAlive(); }

    /// What the array does now, and what became of the fields, by one report of the device; newer
    /// than the newest result's. Waits while the device falls silent, and for nothing else. Any
    /// thread.
    ArrayReading reading() const;
    /// The same state, but OPENING from setPipeline() on until that pipeline's first result. Any
    /// thread.
    ArrayState state() const;
    /// What hands feel: the points of the newest field with their pressures if the array plays it
    /// at this moment; no points while it is muted, lost, at fault, silenced by its hold or a cap,
    /// not open yet, or has nothing to play. Never null. Any thread.
    std::shared_ptr<const PlayedPressure> playedNow() const;
    /// How loud it is at ears, as of now; nothing while there is no pipeline. Any thread.
    haptics::ExposureFigures exposure() const;
    /// How loud it is at each ear, then at each of the options' earPoints; nothing before the first
    /// sound. Any thread.
    std::vector<haptics::PlaceExposure> ears() const;
    /// What a simulated device has played in the last \a duration_s (0 .. 0.1); nothing while none
    /// is open. Any thread.
    PlayedDrives playedOfLate(double duration_s) const;

    /// For how long the solver has been at work on one field, s, while a newer snapshot waits; 0:
    /// none waits. Any thread.
    double solvesFor_s() const;

    /// Hands \a snapshot over and leaves an old one in its place, whose memory the caller may
    /// refill. Never waits for a solve, allocates nothing. A snapshot without objects silences the
    /// device at once and breaks off the solve under way, which is not played.
    void submit(SceneSnapshot& snapshot);

    /// The newest result; null until the first snapshot was processed.
    std::shared_ptr<const HologramResult> latestResult() const;

    /// The number of results published so far; a skipped snapshot publishes the last one again.
    std::uint64_t results() const { return _results; }

    /// The number of snapshots whose result is there, those that a newer one replaced included:
    /// once it is that of all submitted ones, nothing is waited for. Without a pipeline, too.
    std::uint64_t processed() const { return _progress->_processed; }

    /// The same for who waits, perhaps beyond this object's end. Any thread.
    class Progress
    {
    public:
        /// Waits, at most \a timeout_s, until processed is \a snapshots or more. Returns false if
        /// it isn't; at once when the thread ends.
        bool await(std::uint64_t snapshots, double timeout_s);
        bool isEnded() const;

    private:
        friend class HologramThread;
        void advance(std::uint64_t snapshots);
        void end();

        std::atomic<std::uint64_t> _processed{0};
        mutable base::Mutex _mutex;
        base::Condition _changed;
        bool _isEnded MIDAIR_GUARDED_BY(_mutex) = false;
    };
    std::shared_ptr<Progress> progress() const { return _progress; }
    /// The number of snapshots handed over so far.
    std::uint64_t submitted() const { return _slot.puts(); }

    /// The pipeline's counters as of the last processed snapshot; newer than the result's own if
    /// that snapshot was skipped.
    HologramCounters counters() const;

private:
    /// How the thread makes its pipelines, and when again.
    struct Maker
    {
        PipelineFactory make;
        StaleCheck isStale;
    };

    void run();
    bool takeMaker(Maker& maker);
    void makePipeline(Maker& maker, std::unique_ptr<HologramPipeline>& pipeline);
    void makeOnce(const PipelineFactory& make, std::unique_ptr<HologramPipeline>& pipeline);
    bool hasNewOptions() const;
    bool useNewOptions(Maker& maker, std::unique_ptr<HologramPipeline>& pipeline);
    void setAtWork(HologramPipeline* pipeline);
    void silenceNow();
    /// Publishes a result without fields, for there is no pipeline; \a why: the error, if any.
    void publishClosed(haptics::StopReason stop, const std::optional<base::Message>& why);
    void publish(std::shared_ptr<const HologramResult> result, const HologramCounters& counters);

    /// What is to be played with before the next snapshot.
    struct Wanted
    {
        Maker maker;                            ///< without make: the current pipeline stays
        std::optional<HologramOptions> options; ///< none: its options stay
        PipelineFactory otherwise;              ///< makes a pipeline that has them
    };
    struct Published
    {
        std::shared_ptr<const HologramResult> result;
        HologramCounters counters;
    };

    const std::shared_ptr<device::Lead> _lead;
    base::LatestSlot<SceneSnapshot> _slot;
    base::StopSource _stop; ///< requested and cleared under the slot's lock

    mutable base::Mutex _mutex; ///< held for a copy at most
    Wanted _wanted MIDAIR_GUARDED_BY(_mutex);
    Published _published MIDAIR_GUARDED_BY(_mutex);
    std::atomic<std::uint64_t> _results{0};
    const std::shared_ptr<Progress> _progress = std::make_shared<Progress>();
    std::atomic<double> _restWorkSince_s{0.0}; ///< start of attend(), steady clock; 0: not running
    std::atomic<bool> _opening{true};

    mutable base::Mutex _atWorkMutex; ///< held while a device falls silent
    HologramPipeline* _atWork MIDAIR_GUARDED_BY(_atWorkMutex) = nullptr;

    std::thread _thread; ///< last: it uses all other members
};

} // namespace midair::bridge
