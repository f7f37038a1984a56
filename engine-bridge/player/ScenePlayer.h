#pragma once

#include "device/limits/UserLimits.h"
#include "engine-bridge/air/AirTemperature.h"
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
#include <string>
#include <vector>

namespace midair::bridge
{

/// The frame that was handed over last, to find whether another one differs.
class SubmittedFrame
{
public:
    /// From now on every frame differs.
    void forget() { _isAny = false; }
    bool isAny() const { return _isAny; }

    /// Notes \a snapshot, which is about to be handed over at \a now_s (steady clock).
    void note(const SceneSnapshot& snapshot, double now_s);
    double since_s() const { return _at_s; }

    /// Returns true if \a snapshot differs. \a objectsToo: false compares only what is around the
    /// objects, where it is known that they are the same.
    bool differs(const SceneSnapshot& snapshot, bool objectsToo) const;

    bool hasObjects() const { return !_felt.empty(); }

private:
    /// What of an object the field depends on.
    struct Felt
    {
        std::uint64_t id = 0;
        std::uint64_t meshId = 0;
        HapticProperties properties;
        std::vector<Eigen::Vector4d> clips;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    };
    static bool isSame(const HapticObject& object, const Felt& felt);

    std::deque<Felt> _felt; // grows without moving what it has
    HandsAndObstacles _around;
    Eigen::Matrix3Xd _ears = Eigen::Matrix3Xd(3, 0);
    double _at_s = 0.0;
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

/// Plays a scene whose frames somebody hands in: settings in, with their caps and their air; hands,
/// touches and forces; a hologram thread with its device; messages, state and counts out. It knows
/// no scene graph and no handles.
///
/// Only the functions that say so may be called from any thread; all others belong to one thread at
/// a time.
class ScenePlayer
{
public:
    /// What those who play scenes do in their own way.
    struct Host
    {
        base::MessageLog::Print print; ///< as of MessageLog
        HandTracker::Opener openHands; ///< as of HandTracker
        /// changes the options of each new pipeline; none: they stay
        std::function<void(HologramOptions&)> filter = {};
        /// as of HeadTracker
        HeadTracker::Opener openHead = [](const std::string& text)
        { return bridge::openHead(text); };
    };

    explicit ScenePlayer(Host host);
    ~ScenePlayer(); ///< silences the array before it returns
    ScenePlayer(const ScenePlayer&) = delete;
    ScenePlayer& operator=(const ScenePlayer&) = delete;

    /// Changes the options of each new pipeline from now on.
    void setFilter(std::function<void(HologramOptions&)> filter)
    {
        _host.filter = std::move(filter);
    }

    /// \{ Settings.

    /// Plays by \a settings, which are in their ranges, on \a on from the next frame on. Only
    /// another array or device is opened anew; all else acts on what is open. What changes while
    /// nothing may be played waits. \a owner: the scene's name in messages.
    void configure(std::shared_ptr<const SceneSettings> settings,
                   const PlayedOn& on,
                   const std::string& owner);
    /// The settings of the last configure().
    const SceneSettings& settings() const { return *_wanted.settings; }
    /// What the last configure() named; nothing after close() and end().
    const PlayedOn& playedOn() const { return _wanted.on; }
    /// The settings as they are played: with all caps, and the temperature that is followed.
    SceneSettings playedSettings() const;
    /// The strictest caps that scenes inside this one have; they count from the next frame on.
    void setInnerLimits(const device::UserCaps& limits);
    /// Reads the user's caps and the thermometer again. To be called in each frame, and before
    /// mayPlay() is asked of new settings.
    void refresh();
    /// Why the user's caps let nothing be played; empty: nothing is wrong with them.
    const std::vector<std::string>& whySilenced() const { return _caps.wrong; }
    /// False: the scene is disabled, or whySilenced() says why.
    bool mayPlay() const { return _wanted.settings->enabled && _caps.wrong.empty(); }
    /// Opens what the settings say before the first frame comes.
    void open();
    /// \}

    /// \{ Frames.

    /// The snapshot of the next frame, to be filled: all but its hands.
    SceneSnapshot& snapshot() { return _snapshot; }
    /// Plays the frame that snapshot() holds. \a handsToArray: transform from the world of the hand
    /// sources, in metres, to the array. \a isChanged: false, if it is known that its objects are
    /// those of the frame before. Returns true if it was handed to the thread; snapshot() then
    /// holds an older one.
    bool play(const Eigen::Isometry3d& handsToArray, bool isChanged = true);
    /// A frame in which nothing has changed, and nothing was looked at: a sign of life.
    void rest();
    /// Silences the array until the next play(), and ends all touches.
    void silence();
    /// Silences the array, closes the device and the hands; the next configure() opens them again.
    /// Doesn't wait for the device: calls that follow end what it has closed. Returns true if
    /// something was open until now.
    bool close();
    /// close() has come to its end.
    bool isClosed() const { return !_opening.thread; }
    /// Ends all touches and the thread; what is returned has to be destroyed, which waits for the
    /// device. Nothing is opened before the next configure().
    std::shared_ptr<void> end();
    bool hasSubmitted() const { return _submitted.isAny(); }
    double submitted_s() const { return _submitted.since_s(); } ///< steady clock
    /// \}

    /// Silences the array at once, with the device open and hands and touches going on, until
    /// setMuted(false). Any thread.
    void setMuted(bool muted);
    bool isMuted() const; ///< any thread
    /// Silences the array at once, and breaks off the solve under way; the next frame may play
    /// again. Waits for no hand source and no callback. Any thread.
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
    /// From keepClosed() on nothing is opened. locateHands() completes snapshot(), as play() does.
    void keepClosed();
    void locateHands(const Eigen::Isometry3d& handsToArray);
    HologramOptions options() const;
    HologramThread::PipelineFactory pipelineMaker(const HologramOptions& options) const
    {
        return _maker.factory(options);
    }
    std::uint64_t changes() const { return _opening.changes; } ///< how often options() has changed
    /// \}

    /// \{ Any thread.
    std::shared_ptr<const HologramResult> latestResult() const;
    /// Waits, at most \a timeout_s, for the field of the newest frame that was handed over: the
    /// result is then that of this frame, or of a newer one. Returns why there is none; empty:
    /// there is. At once where none comes: nothing is played, or it may not be. It may be called
    /// on the thread that plays the frames as well.
    std::string awaitField(double timeout_s) const;
    SceneStatistics statistics() const;
    /// As SceneStatistics::ears.
    std::vector<haptics::PlaceExposure> ears() const;
    ArrayState state() const; ///< CLOSED while there is no thread
    ArrayReading reading() const;
    /// What a simulated device has played in the last \a duration_s (0 .. 0.1).
    PlayedDrives playedOfLate(double duration_s) const;
    /// The array as it was read last; null: it wasn't, or can't be.
    std::shared_ptr<const haptics::TransducerArray> array() const { return _maker.array(); }
    haptics::Medium medium() const;
    /// What hands feel at this moment; never null.
    std::shared_ptr<const PlayedPressure> playedNow() const;
    /// \}

private:
    /// What is played with: what fields depend on.
    struct Plan
    {
        std::shared_ptr<const SceneSettings> settings;
        PlayedOn on;
        std::string owner;
        device::UserCaps limits; ///< the strictest of the user's and of inner scenes
        double air_C = 20.0;
    };
    struct Caps
    {
        device::UserCaps user;
        device::UserCaps inner;
        std::vector<std::string> wrong; ///< why nothing may be played
    };
    struct Opening
    {
        std::unique_ptr<HologramThread> thread; ///< null: there is none
        bool isOpen = false;                    ///< it has what _played says
        bool isKeptClosed = false;
        std::uint64_t changes = 0;
    };
    /// What has been taken of the thread's results.
    struct Taken
    {
        std::uint64_t results = 0;
        std::shared_ptr<const HologramResult> newest;
        double slowUntil_s = 0.0; ///< for how long a slow solver is told already; 0: none is
    };
    /// What other threads see.
    struct Shared
    {
        mutable base::Mutex mutex;
        /// the thread's, or that of the next one
        std::shared_ptr<device::Lead>
            lead MIDAIR_GUARDED_BY(mutex) = std::make_shared<device::Lead>();
        /// that of _opening, which outlives each lock
        HologramThread* thread MIDAIR_GUARDED_BY(mutex) = nullptr;
        /// that of a thread that ended
        std::shared_ptr<const HologramResult> closed MIDAIR_GUARDED_BY(mutex);
        haptics::Medium medium MIDAIR_GUARDED_BY(mutex);
        /// why nothing may be played, as of the last frame; empty: it may
        std::string whySilent MIDAIR_GUARDED_BY(mutex);
        SceneStatistics counts MIDAIR_GUARDED_BY(mutex);      ///< those of the player's own
        LatencyStatistics latencies MIDAIR_GUARDED_BY(mutex); ///< ms, of the newest fields
    };

    void judgeCaps();
    void apply();
    void start(const HologramOptions& options);
    bool submit();
    bool mayTouch() const;
    bool mayListen();
    void noteSilence();
    void tellSlowSolver(double now_s);

    Host _host;
    Plan _wanted;
    Plan _played; ///< what the thread has
    Caps _caps;
    base::MessageLog _log;
    AirTemperature _air{_log};
    HandTracker _hands;
    HeadTracker _heads;
    double _handsSeen_s = -1e9; ///< steady clock; when there was a hand
    PipelineMaker _maker;
    SceneSnapshot _snapshot; ///< being filled
    SubmittedFrame _submitted;
    Taken _taken;
    Opening _opening;
    Shared _shared;
};

} // namespace midair::bridge
