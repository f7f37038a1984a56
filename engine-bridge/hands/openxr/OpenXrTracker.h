#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/Head.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

class OpenXrSession;

/// Space of the runtime for locating hands; metres, y up, right-handed.
enum class OpenXrSpace
{
    BEST,  ///< STAGE if the runtime has it, else LOCAL
    STAGE, ///< the room: fixed, with the origin on the floor
    LOCAL  ///< origin near the head's place at the last recentring
};

/// Options of an OpenXrTracker.
struct OpenXrOptions
{
    std::string loader = "libopenxr_loader.so.1"; ///< file name of the loader's library
    OpenXrSpace space = OpenXrSpace::BEST;
    /// > 0; seconds before the first new attempt to connect, if that may succeed. Each pause is
    /// twice as long as the last one, up to 60 s.
    double retry_s = 5.0;
};

bool operator==(const OpenXrOptions& a, const OpenXrOptions& b);

/// A client of an OpenXrTracker for the hands, or for the head, with its own horizon.
struct OpenXrAsker
{
    explicit OpenXrAsker(bool forHead) : isForHead(forHead) {}

    const bool isForHead;
    std::atomic<double> horizon_s{0.0};
    /// Time of its last request, steady clock. Guarded by the tracker, like the following members.
    double asked_s = -std::numeric_limits<double>::infinity();
    HandFrame frame; ///< time_s: steady clock, when it was located
    Head head;       ///< the same
};

/// Reads the hands and the head that an OpenXR runtime tracks, on a separate thread, so that no
/// other thread waits for the runtime: in the session that the headset's view or the program lends
/// (OpenXrLending), otherwise through its own connection, which is restored after a headset or
/// session was lost.
class OpenXrTracker
{
public:
    /// Seconds between two reads while hands or the head are requested.
    static constexpr double kInterval_s = 0.004;
    /// Older data (s) is discarded: the runtime doesn't answer.
    static constexpr double kStale_s = 0.2;

    /// Returns the tracker for these options; callers with equal options share one, because OpenXR
    /// allows one instance per program.
    static std::shared_ptr<OpenXrTracker> open(const OpenXrOptions& options);

    explicit OpenXrTracker(const OpenXrOptions& options);
    ~OpenXrTracker(); ///< waits for a running call to the runtime
    OpenXrTracker(const OpenXrTracker&) = delete;
    OpenXrTracker& operator=(const OpenXrTracker&) = delete;

    /// Returns a new client for hands or for the head. Any thread.
    std::shared_ptr<OpenXrAsker> newAsker(bool forHead);

    /// Stores the newest hands for \a asker, in the runtime's space, in \a frame, with their age;
    /// returns false if none are tracked. Never waits for the runtime. Any thread.
    bool latest(OpenXrAsker& asker, HandFrame& frame);

    /// See latest(), for the head. Any thread.
    bool latestHead(OpenXrAsker& asker, Head& head);

    /// Sets the prediction time of \a asker, \a ahead_s (0 .. 1, clamped) after the time of each
    /// read; 0, the default: no prediction. Any thread.
    static void setHorizon(OpenXrAsker& asker, double ahead_s);

    /// Returns the messages from number \a told on; sets \a told to the number of all messages. Any
    /// thread.
    std::vector<std::string> messages(std::size_t& told) const;

    /// One line of text: the runtime and its state. Any thread.
    std::string status() const;

private:
    void run();
    bool takeTurn();
    void connect();
    void pause(double time_s, bool isTaken);
    /// Connects and reads until the session is over; returns false if there was no session. Sets \a
    /// again to true if a later attempt may succeed.
    bool followSession(bool& again);
    void followLent();
    /// \a own: null: uses the lent session.
    void follow(OpenXrSession* own);
    void lose(const std::string& why);
    void say(const std::string& message);

    using Askers = std::vector<std::shared_ptr<OpenXrAsker>>;
    struct Reading;
    Askers recentAskers() MIDAIR_REQUIRES(_mutex);
    void publish(Askers& askers, const std::vector<Reading>& read) MIDAIR_REQUIRES(_mutex);
    double noteAsked(double& asked_s) MIDAIR_REQUIRES(_mutex);

    const OpenXrOptions _options;
    std::atomic<bool> _stop{false};
    mutable base::Mutex _mutex;
    base::Condition _wake;
    std::vector<std::weak_ptr<OpenXrAsker>> _askers MIDAIR_GUARDED_BY(_mutex);
    bool _isWanted MIDAIR_GUARDED_BY(_mutex) = false;   ///< a client has started to ask
    std::size_t _lentTold = 0;                          ///< messages of OpenXrLending
    std::size_t _frames MIDAIR_GUARDED_BY(_mutex) = 0;  ///< frames with a hand
    std::size_t _leftOut MIDAIR_GUARDED_BY(_mutex) = 0; ///< OpenXrSession::jointsLeftOut()
    std::string _condition MIDAIR_GUARDED_BY(_mutex) = "openxr: connecting";
    base::MessageLog _messages MIDAIR_GUARDED_BY(_mutex);
    std::thread _thread; ///< last: it uses the other members
};

} // namespace midair::bridge
