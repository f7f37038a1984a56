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

/// Runs a HologramPipeline in a thread: takes the newest snapshot and publishes its result; frames
/// never wait for it. While no snapshot comes, it calls HologramPipeline::attend().
///
/// submit() belongs to one thread, and so do setPipeline() and setOptions(). The pipeline is made
/// in its thread when the first snapshot comes, because opening a device may take a while. The
/// destructor silences the device and aborts the running solve, which takes some milliseconds; it
/// waits for an application's solver that doesn't check SolverOptions::stop.
class HologramThread
{
public:
    using PipelineFactory = std::function<std::unique_ptr<HologramPipeline>()>;
    /// Returns true if the pipeline should be made again because a file that it uses has changed.
    /// Called between snapshots, so it has to be cheap.
    using StaleCheck = std::function<bool()>;

    /// Starts the thread, which makes a pipeline with \a options.
    explicit HologramThread(HologramOptions options);
    /// Starts the thread; \a makePipeline: see setPipeline(). \a lead, not null, leads all its
    /// pipelines; making this object is a sign of life.
    explicit HologramThread(PipelineFactory makePipeline,
                            StaleCheck isStale = {},
                            std::shared_ptr<device::Lead> lead = std::make_shared<device::Lead>());
    ~HologramThread();

    HologramThread(const HologramThread&) = delete;
    HologramThread& operator=(const HologramThread&) = delete;

    /// Replaces the pipeline before the next snapshot is processed. The old one is destroyed and
    /// its device closed before \a makePipeline runs in the pipeline's thread. If \a makePipeline
    /// returns null, nothing is played until the next setPipeline(); if it throws, the result is
    /// REFUSED, with the message. Doesn't wait; a running solve is aborted and its result is
    /// STOPPED. When \a isStale, called in the same thread, returns true, \a makePipeline runs
    /// again and the last snapshot is processed again.
    void setPipeline(PipelineFactory makePipeline, StaleCheck isStale = {});

    /// Changes the pipeline's options before the next snapshot is processed; its device stays open
    /// (HologramPipeline::reconfigure()). A snapshot has to follow. A running solve continues, but
    /// a stricter cap applies at once: a lower amplitude to the playing field, a lower pressure by
    /// silence until the next snapshot is processed. \a otherwise makes a pipeline with these
    /// options, see setPipeline(): now if there is none, else when isStale returns true.
    void setOptions(HologramOptions options, PipelineFactory otherwise);

    /// Silences the array at once and keeps it silent, with its device open, until setMuted(false),
    /// which plays the newest field again. Any thread.
    void setMuted(bool muted);

    /// Silences the array at once and aborts the running solve, whose field is not played; the next
    /// snapshot is played again. Any thread.
    void silence();

    /// To be called with each frame, changed or not: a device with a hold (SafetyLimits::hold_s)
    /// falls silent if neither this nor submit() is called for that time. Fields, results and
    /// readers are no signs of life. Never waits for the device. Any thread.
    void keepAlive() { _lead->keepAlive(); }

    /// State of the array and fate of its fields, from one report of the device; newer than the
    /// newest result's. Waits only while the device falls silent. Any thread.
    ArrayReading reading() const;
    /// The same state, but OPENING from setPipeline() until that pipeline's first result. Any
    /// thread.
    ArrayState state() const;
    /// Pressures that hands feel: the points of the newest field if the array plays it now; no
    /// points while it is muted, lost, at fault, silenced by its hold or a cap, not open yet, or
    /// has nothing to play. Never null. Any thread.
    std::shared_ptr<const PlayedPressure> playedNow() const;
    /// Sound level at ears now; empty without a pipeline. Any thread.
    haptics::ExposureFigures exposure() const;
    /// Seen and felt objects of the newest snapshot; empty without a pipeline. Any thread.
    std::vector<SeenObject> seen() const;
    /// Level at each ear, then at each of the options' earPoints; empty before the first sound. Any
    /// thread.
    std::vector<haptics::PlaceExposure> ears() const;
    /// Drives that a simulated device has played in the last \a duration_s (0 .. 0.1); empty while
    /// none is open. Any thread.
    PlayedDrives playedOfLate(double duration_s) const;

    /// Duration of the running solve, s, while a newer snapshot waits; 0 if none waits. Any thread.
    double solvesFor_s() const;

    /// Hands \a snapshot over and replaces it by an old one, whose memory the caller may reuse.
    /// Never waits for a solve, never allocates. A snapshot without objects silences the device at
    /// once and aborts the running solve, which is not played.
    void submit(SceneSnapshot& snapshot);

    /// Newest result; null until the first snapshot was processed.
    std::shared_ptr<const HologramResult> latestResult() const;

    /// Number of published results; a skipped snapshot publishes the last one again.
    std::uint64_t results() const { return _results; }

    /// Number of processed snapshots, including replaced ones: once it equals that of submitted
    /// ones, nothing is pending. Also without a pipeline.
    std::uint64_t processed() const { return _progress->_processed; }

    /// The same for waiting callers, which may outlive this object. Any thread.
    class Progress
    {
    public:
        /// Waits up to \a timeout_s until \a snapshots are processed. Returns false if they aren't;
        /// at once when the thread ends.
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
    /// Number of snapshots handed over.
    std::uint64_t submitted() const { return _slot.puts(); }

    /// The pipeline's counters after the last processed snapshot; newer than the result's own if
    /// that snapshot was skipped.
    HologramCounters counters() const;

private:
    /// How and when the thread makes its pipelines.
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
    /// Publishes a result without fields, because there is no pipeline; \a why: the error, if any.
    void publishClosed(haptics::StopReason stop, const std::optional<base::Message>& why);
    void publish(std::shared_ptr<const HologramResult> result, const HologramCounters& counters);

    /// Settings for the next snapshot.
    struct Wanted
    {
        Maker maker;                            ///< without make: keep the current pipeline
        std::optional<HologramOptions> options; ///< none: keep its options
        PipelineFactory otherwise;              ///< makes a pipeline with these options
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
