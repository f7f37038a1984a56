#pragma once

#include "device/limits/UserLimits.h"
#include "engine-bridge/air/AirTemperature.h"
#include "engine-bridge/display/Coincidence.h"
#include "engine-bridge/hands/tracking/HandTracker.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "engine-bridge/heads/HeadTracker.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/player/PipelineMaker.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"

#include <osgMidair/SceneSettings>
#include <osgMidair/SceneStatistics>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The last frame handed over, for comparison with the next one.
class SubmittedFrame
{
public:
    /// Makes every following frame differ.
    void forget() { _isAny = false; }
    bool isAny() const { return _isAny; }

    /// Stores \a snapshot, which is handed over next, at \a now_s (steady clock).
    void note(const SceneSnapshot& snapshot, double now_s);
    double since_s() const { return _at_s; }

    /// Returns true if an object moved twice in a row a moment ago: an extrapolated object must
    /// learn that it has come to rest.
    bool isMoving(double now_s) const { return now_s < _movesUntil_s; }

    /// Returns true if \a snapshot differs. \a objectsToo: false compares only the surroundings, if
    /// the objects are known to be the same.
    bool differs(const SceneSnapshot& snapshot, bool objectsToo) const;

    bool hasObjects() const { return !_felt.empty(); }

private:
    /// Properties of an object that affect the field.
    struct Felt
    {
        std::uint64_t id = 0;
        std::uint64_t meshId = 0;
        HapticProperties properties;
        std::vector<Eigen::Vector4d> clips;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    };
    static bool isSame(const HapticObject& object, const Felt& felt);

    std::deque<Felt> _felt; // grows without moving its elements
    HandsAndObstacles _around;
    std::vector<haptics::FlatFace> _reflectors;
    std::vector<haptics::ReflectingBody> _bodies;
    Eigen::Matrix3Xd _ears = Eigen::Matrix3Xd(3, 0);
    double _at_s = 0.0;
    double _moved_s = -1e9;      // steady clock; time of the last pose change
    double _movesUntil_s = -1e9; // steady clock
    bool _isAny = false;
};

/// Percentiles over the last kWindow values.
class LatencyStatistics
{
public:
    static constexpr std::size_t kWindow = 1024;

    void add(double value)
    {
        _values[_count % kWindow] = value;
        ++_count;
    }

    /// Returns the percentile at \a fraction (0 .. 1) of the values in the window; 0 if there are
    /// none.
    double percentile(double fraction) const
    {
        const auto end = static_cast<std::ptrdiff_t>(std::min(_count, kWindow));
        return base::percentile({_values.begin(), _values.begin() + end}, fraction);
    }

private:
    std::array<double, kWindow> _values{};
    std::size_t _count = 0;
};

/// Plays a scene whose frames the caller submits. Input: settings, caps, air, hands, touches and
/// forces. Output: a hologram thread with its device, messages, state and counts. It knows neither
/// scene graphs nor handles.
///
/// Only functions documented for any thread may be called from any thread; all others belong to one
/// thread at a time.
class ScenePlayer
{
public:
    /// Functions that differ between users of a ScenePlayer.
    struct Host
    {
        base::MessageLog::Print print; ///< see MessageLog
        HandTracker::Opener openHands; ///< see HandTracker
        /// changes the options of each new pipeline; empty: no change
        std::function<void(HologramOptions&)> filter = {};
        /// see HeadTracker
        HeadTracker::Opener openHead = [](const std::string& text)
        { return bridge::openHead(text); };
    };

    explicit ScenePlayer(Host host);
    ~ScenePlayer(); ///< silences the array before it returns
    ScenePlayer(const ScenePlayer&) = delete;
    ScenePlayer& operator=(const ScenePlayer&) = delete;

    /// Sets the function that changes the options of each new pipeline.
    void setFilter(std::function<void(HologramOptions&)> filter)
    {
        _host.filter = std::move(filter);
    }

    /// \{ Settings.

    /// Applies \a settings, which must be in their ranges, and \a on from the next frame on. Only
    /// another array or device is opened again; all other changes act on the open pipeline. Changes
    /// wait while nothing may be played. \a owner: the scene's name in messages.
    void configure(std::shared_ptr<const SceneSettings> settings,
                   const PlayedOn& on,
                   const std::string& owner);
    /// Settings of the last configure().
    const SceneSettings& settings() const { return *_wanted.settings; }
    /// Array and device of the last configure(); empty after close() and end().
    const PlayedOn& playedOn() const { return _wanted.on; }
    /// Settings as played: with all caps and the measured temperature.
    SceneSettings playedSettings() const;
    /// Sets the strictest caps of scenes inside this one; they apply from the next frame on.
    void setInnerLimits(const device::UserCaps& limits);
    /// Reads the user's caps and the thermometer again. Call it in each frame, and before mayPlay()
    /// for new settings.
    void refresh();
    /// Why the user's environment forbids playing: the first reason; empty if it doesn't.
    std::string whySilenced() const;
    /// False if the scene is disabled, or for the reason of whySilenced().
    bool mayPlay() const { return _wanted.settings->enabled && whySilenced().empty(); }
    /// Opens the pipeline before the first frame comes.
    void open();
    /// \}

    /// \{ Frames.

    /// Snapshot of the next frame, to be filled except for its hands.
    SceneSnapshot& snapshot() { return _snapshot; }
    /// Plays the frame in snapshot(). \a handsToArray: transform from the world of the hand
    /// sources, in metres, to the array. \a isChanged: false if the objects are known to be those
    /// of the frame before. Returns true if the frame was handed to the thread; snapshot() then
    /// holds an older one.
    bool play(const Eigen::Isometry3d& handsToArray, bool isChanged = true);
    /// Sets when the light of the next frame is seen (\a steady_s); without it, the display's
    /// latency after the snapshot's time.
    void setDisplayTime(double steady_s) { _times.display_s = steady_s; }
    /// Sets the viewer and the display, from the next frame on.
    void setViewing(Viewing viewing) { _times.viewing = std::move(viewing); }
    /// To be called for a frame without any change or check: a sign of life.
    void rest();
    /// Silences the array until the next play(), and ends all touches.
    void silence();
    /// Silences the array, closes the device and the hands; the next configure() opens them again.
    /// Doesn't wait for the device: later calls finish the closing. Returns true if something was
    /// open.
    bool close();
    /// Returns true when close() has finished.
    bool isClosed() const { return !_opening.thread; }
    /// Ends all touches and the thread. Destroy the returned object, which waits for the device.
    /// Nothing is opened before the next configure().
    std::shared_ptr<void> end();
    bool hasSubmitted() const { return _submitted.isAny(); }
    double submitted_s() const { return _submitted.since_s(); } ///< steady clock
    /// \}

    /// Silences the array at once until setMuted(false); the device stays open, hands and touches
    /// continue. Any thread.
    void setMuted(bool muted);
    bool isMuted() const; ///< any thread
    /// Silences the array at once and aborts the running solve; the next frame may play again.
    /// Doesn't wait for hand sources or callbacks. Any thread.
    void silenceNow();

    /// As HandTracker::setNamed().
    std::string openHands(const std::string& uri);
    /// As HandTracker::setSource().
    void setHandSource(std::shared_ptr<HandSource> source);
    /// As HandTracker::setPresses(), for the next play().
    void setPresses(std::vector<HandPress> presses) { _hands.setPresses(std::move(presses)); }
    const HandTracker& hands() const { return _hands; }
    /// \{ The same of the head. locateHead() finds it for the frame of \a time_s, before the ears
    /// of its snapshot are filled.
    std::string openHead(const std::string& text);
    void setHeadSource(std::shared_ptr<HeadSource> source);
    void locateHead(double time_s) { _heads.locate(time_s); }
    const HeadTracker& heads() const { return _heads; }
    /// \}
    base::MessageLog& log() { return _log; }
    const base::MessageLog& log() const { return _log; }
    /// Takes over the messages of the newest result.
    void takeResult();

    /// \{ For who solves by itself: what the next pipeline would be made with, and what makes it.
    /// After keepClosed() nothing is opened. locateHands() completes snapshot(), like play().
    void keepClosed();
    void locateHands(const Eigen::Isometry3d& handsToArray);
    HologramOptions options() const;
    HologramThread::PipelineFactory pipelineMaker(const HologramOptions& options) const
    {
        return _maker.factory(options);
    }
    std::uint64_t changes() const { return _opening.changes; } ///< number of changes of options()
    /// \}

    /// \{ Any thread.
    std::shared_ptr<const HologramResult> latestResult() const;
    /// Waits up to \a timeout_s for the field of the newest frame that was handed over; the result
    /// is then that of this frame or a newer one. Returns why there is none; empty if there is.
    /// Returns at once if none will come because nothing is or may be played. May also be called on
    /// the thread that plays the frames.
    std::string awaitField(double timeout_s) const;
    SceneStatistics statistics() const;
    /// See SceneStatistics::coincidence.
    std::vector<CoincidenceFigures> coincidence() const;
    /// See SceneStatistics::ears.
    std::vector<haptics::PlaceExposure> ears() const;
    ArrayState state() const; ///< CLOSED while there is no thread
    ArrayReading reading() const;
    /// Drives that a simulated device has played in the last \a duration_s (0 .. 0.1).
    PlayedDrives playedOfLate(double duration_s) const;
    /// The array as last read; null: not read yet, or unreadable.
    std::shared_ptr<const haptics::TransducerArray> array() const { return _maker.array(); }
    haptics::Medium medium() const;
    /// The pressures that hands feel now; never null.
    std::shared_ptr<const PlayedPressure> playedNow() const;
    /// \}

private:
    /// Everything that fields depend on.
    struct Plan
    {
        std::shared_ptr<const SceneSettings> settings;
        PlayedOn on;
        std::string owner;
        device::UserCaps limits; ///< strictest caps of the user and of inner scenes
        double air_C = 20.0;
    };
    struct Caps
    {
        device::UserCaps user;
        device::UserCaps inner;
        std::vector<std::string> wrong; ///< reasons why nothing may be played
    };
    struct Opening
    {
        std::unique_ptr<HologramThread> thread; ///< null: there is none
        bool isOpen = false;                    ///< it uses _played
        bool isKeptClosed = false;
        std::uint64_t changes = 0;
    };
    /// What was taken from the thread's results.
    struct Taken
    {
        std::uint64_t results = 0;
        std::shared_ptr<const HologramResult> newest;
        double slowUntil_s = 0.0;  ///< for how long a slow solver is told already; 0: none is
        double faintSince_s = 0.0; ///< since when the field can't be felt
        bool isFaintTold = false;
    };
    /// Times of frames, and their viewer.
    struct Times
    {
        Viewing viewing;
        double handsSeen_s = -1e9;       ///< steady clock; last time with a hand
        std::optional<double> display_s; ///< steady clock; when the light of the next frame is seen
    };
    /// State shared with other threads.
    struct Shared
    {
        mutable base::Mutex mutex;
        /// of the thread, or of the next one
        std::shared_ptr<device::Lead>
            lead MIDAIR_GUARDED_BY(mutex) = std::make_shared<device::Lead>();
        /// points to that of _opening, which outlives each lock
        HologramThread* thread MIDAIR_GUARDED_BY(mutex) = nullptr;
        /// result of a thread that ended
        std::shared_ptr<const HologramResult> closed MIDAIR_GUARDED_BY(mutex);
        haptics::Medium medium MIDAIR_GUARDED_BY(mutex);
        /// why nothing may be played, as of the last frame; empty if it may
        std::string whySilent MIDAIR_GUARDED_BY(mutex);
        SceneStatistics counts MIDAIR_GUARDED_BY(mutex);         ///< the player's own counts
        LatencyStatistics latencies MIDAIR_GUARDED_BY(mutex);    ///< ms, of the newest fields
        CoincidenceOptions coincidence MIDAIR_GUARDED_BY(mutex); ///< as of the newest frame
    };

    SceneStatistics counted() const;
    void judgeCaps();
    void apply();
    void start(const HologramOptions& options);
    bool submit();
    bool mayTouch() const;
    bool mayListen();
    void setLight();
    CoincidenceOptions knownErrors(const Eigen::Isometry3d& worldToArray) const;
    void noteSilence();
    void tellSlowSolver(double now_s);
    void tellFaintField(double now_s);

    Host _host;
    Plan _wanted;
    Plan _played; ///< plan of the thread
    Caps _caps;
    base::MessageLog _log;
    AirTemperature _air{_log};
    HandTracker _hands;
    HeadTracker _heads;
    Times _times;
    PipelineMaker _maker;
    SceneSnapshot _snapshot; ///< being filled
    SubmittedFrame _submitted;
    Taken _taken;
    Opening _opening;
    Shared _shared;
};

} // namespace midair::bridge
