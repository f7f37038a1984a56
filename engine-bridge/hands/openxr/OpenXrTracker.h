#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/Head.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

class OpenXrSession;

/// The runtime's space in which hands are located; all are in metres, y up, right-handed.
enum class OpenXrSpace
{
    BEST,  ///< STAGE if the runtime has it, else LOCAL
    STAGE, ///< the room: fixed, with the origin on the floor
    LOCAL  ///< origin about where the head was when the runtime was last recentred
};

/// Options of an OpenXrTracker.
struct OpenXrOptions
{
    std::string loader = "libopenxr_loader.so.1"; ///< file name of the loader's library
    OpenXrSpace space = OpenXrSpace::BEST;
    /// > 0; seconds until the first new attempt to connect, if that may succeed. Each pause is
    /// twice as long as the one before, up to 60 s.
    double retry_s = 5.0;
};

bool operator==(const OpenXrOptions& a, const OpenXrOptions& b);

/// Connects to an OpenXR runtime and reads the hands and the head that it tracks, on a thread of
/// its own, so that no other thread waits for the runtime. Connects again after a headset or
/// session was lost.
class OpenXrTracker
{
public:
    /// Seconds between two reads while hands, or the head, are asked for.
    static constexpr double kInterval_s = 0.004;
    /// What is older than this (s) counts as nothing: the runtime doesn't answer.
    static constexpr double kStale_s = 0.2;

    /// The tracker for these options; callers with the same options share one, since OpenXR allows
    /// one instance per program.
    static std::shared_ptr<OpenXrTracker> open(const OpenXrOptions& options);

    explicit OpenXrTracker(const OpenXrOptions& options);
    ~OpenXrTracker(); ///< waits for the call to the runtime that is under way
    OpenXrTracker(const OpenXrTracker&) = delete;
    OpenXrTracker& operator=(const OpenXrTracker&) = delete;

    /// Puts the newest hands, in the runtime's space, into \a frame, with their age; returns false
    /// if none are tracked. Never waits for the runtime. Any thread.
    bool latest(HandFrame& frame);

    /// As latest(), for the head. Any thread.
    bool latestHead(Head& head);

    /// From now on the runtime is asked for hands \a ahead_s (0 .. 1, else cut) after the time that
    /// it is then; 0, the default: for those of that time. Any thread.
    void setHorizon(double ahead_s);
    void setHeadHorizon(double ahead_s); ///< the same for the head

    /// The messages from number \a told on; sets \a told to the number of all messages. Any thread.
    std::vector<std::string> messages(std::size_t& told) const;

    /// One line of text: the runtime and its state. Any thread.
    std::string status() const;

private:
    void run();
    bool takeTurn();
    /// Connects and reads hands until the session is over; returns false if there was no session.
    /// Sets \a again to true if a later attempt may succeed.
    bool followSession(bool& again);
    void follow(OpenXrSession& session);
    void lose(const std::string& why);
    void say(const std::string& message);

    /// When what is tracked was asked for last, steady clock.
    struct Asked
    {
        double hands_s;
        double head_s;
    };
    bool isAskedFor() const MIDAIR_REQUIRES(_mutex);
    double noteAsked(double& asked_s) MIDAIR_REQUIRES(_mutex);

    const OpenXrOptions _options;
    std::atomic<bool> _stop{false};
    std::atomic<double> _horizon_s{0.0};
    std::atomic<double> _headHorizon_s{0.0};
    mutable base::Mutex _mutex;
    base::Condition _wake;
    /// time_s: steady clock, when it was located
    HandFrame _frame MIDAIR_GUARDED_BY(_mutex);
    Head _head MIDAIR_GUARDED_BY(_mutex); ///< time_s: as of _frame
    Asked _asked MIDAIR_GUARDED_BY(_mutex);
    std::size_t _frames MIDAIR_GUARDED_BY(_mutex) = 0;  ///< frames with a hand
    std::size_t _leftOut MIDAIR_GUARDED_BY(_mutex) = 0; ///< OpenXrSession::jointsLeftOut()
    std::string _condition MIDAIR_GUARDED_BY(_mutex) = "openxr: connecting";
    base::MessageLog _messages MIDAIR_GUARDED_BY(_mutex);
    std::thread _thread; ///< last: it uses the other members
};

} // namespace midair::bridge
