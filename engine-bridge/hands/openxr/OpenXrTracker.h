#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/base/text/MessageLog.h"

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

class OpenXrSession;

/// Which of a runtime's spaces hands are located in; all are in metres, y up, right-handed.
enum class OpenXrSpace
{
    BEST,  ///< STAGE where the runtime has one, else LOCAL
    STAGE, ///< the room: origin on the floor, stays where it is
    LOCAL  ///< about where the head was when the runtime last recentred
};

struct OpenXrOptions
{
    std::string loader = "libopenxr_loader.so.1"; ///< file name of the loader's library
    OpenXrSpace space = OpenXrSpace::BEST;
    /// > 0; seconds until the runtime is tried again where that may help. Each pause is twice as
    /// long as the one before, up to 60.
    double retry_s = 5.0;
};

bool operator==(const OpenXrOptions& a, const OpenXrOptions& b);

/// Connects to an OpenXR runtime and follows the hands that it tracks on a thread of its own, so
/// that no other thread waits for the runtime. Tries again after a headset or a session has gone
/// away.
class OpenXrTracker
{
public:
    /// Seconds between two looks while hands are asked for, and so the greatest age of a frame.
    static constexpr double kInterval_s = 0.004;
    /// A runtime that has not answered for this long (s) has no hands.
    static constexpr double kStale_s = 0.2;

    /// The tracker for these options; callers with the same options share one, since OpenXR allows
    /// a program one instance.
    static std::shared_ptr<OpenXrTracker> open(const OpenXrOptions& options);

    explicit OpenXrTracker(const OpenXrOptions& options);
    ~OpenXrTracker(); ///< waits for the runtime's answer to what it was asked last
    OpenXrTracker(const OpenXrTracker&) = delete;
    OpenXrTracker& operator=(const OpenXrTracker&) = delete;

    /// The newest hands, in the runtime's space; false where none are tracked. Never blocks. Any
    /// thread.
    bool latest(HandFrame& frame);

    /// Messages from number \a told on, which goes up by their count; each is there once. Any
    /// thread.
    std::vector<std::string> messages(std::size_t& told) const;

    /// One line: the runtime and how it fares. Any thread.
    std::string status() const;

private:
    void run();
    bool takeTurn();
    /// Connects and follows hands until that is over; false where there was no session. \a again: a
    /// later try may do.
    bool followSession(bool& again);
    void follow(OpenXrSession& session);
    void lose(const std::string& why);
    void say(const std::string& message);
    bool isAskedFor() const;

    const OpenXrOptions _options;
    std::atomic<bool> _stop{false};
    mutable std::mutex _mutex; ///< of what follows
    std::condition_variable _wake;
    HandFrame _frame;        ///< time_s: when it was located, steady clock
    double _asked_s;         ///< for hands, last; steady clock
    std::size_t _frames = 0; ///< with a hand
    std::size_t _leftOut = 0;
    std::string _condition = "openxr: connecting";
    base::MessageLog _messages;
    std::thread _thread; ///< last: it uses the rest
};

} // namespace midair::bridge
