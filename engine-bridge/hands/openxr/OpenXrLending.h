#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace midair::bridge
{

class OpenXrSession;

/// An instance and a session of the program, with the types of openxr.h.
struct OpenXrHandles
{
    void (*getInstanceProcAddr)() = nullptr; ///< xrGetInstanceProcAddr
    void* instance = nullptr;
    void* session = nullptr;
    void* space = nullptr; ///< for locating hands and head; null: the kit makes one
};

/// Owner of this process's only OpenXR instance: a tracker, or a lender of a session to all
/// trackers, which is the headset's view or the program. Any thread.
class OpenXrLending
{
public:
    static OpenXrLending& one();

    /// Prevents trackers from having their own connection; returns when a present one has ended.
    /// Returns an error, or an empty text on success.
    std::string take();
    /// Lets trackers connect by themselves again.
    void give();
    bool isTaken() const { return _isTaken; }

    /// Lends \a session to trackers; null: none. Waits until the one before is not in use.
    void lend(OpenXrSession* session);
    /// Calls \a use with the lent session; returns false if there is none.
    bool use(const std::function<void(OpenXrSession&)>& use);

    /// Adds a message for all trackers; messages() returns those from number \a told on.
    void say(const std::string& message);
    std::vector<std::string> messages(std::size_t& told) const { return _messages.newTexts(told); }

    /// Sets the hands at the display time of the present frame, in the runtime's space.
    void show(const HandFrame& frame);
    /// Returns false if no hands were shown lately: that time is unknown.
    bool shown(HandFrame& frame) const;

    /// Returns why the calibration of hands, head and picture is no longer valid: the runtime has
    /// moved its space. Empty: still valid.
    std::string recentred() const;
    void setRecentred(const std::string& why);

    /// Waits until no tracker has a connection, nobody lends one, or \a patience_s is over (below
    /// 0: never), and takes the connection. Returns false on a timeout.
    bool beginOwn(double patience_s, const std::atomic<bool>& stop);
    void endOwn();
    /// Wakes beginOwn(), so that it checks its \c stop.
    void wake();

private:
    mutable base::Mutex _mutex;
    base::Condition _changed;
    std::atomic<bool> _isTaken{false};
    bool _isOwn MIDAIR_GUARDED_BY(_mutex) = false; ///< a tracker has a connection
    HandFrame _shown MIDAIR_GUARDED_BY(_mutex);    ///< time_s: steady clock, when it was shown
    std::string _recentred MIDAIR_GUARDED_BY(_mutex);
    base::Mutex _using; ///< held while the session is in use; locked before \c _mutex
    OpenXrSession* _session MIDAIR_GUARDED_BY(_using) = nullptr;
    base::MessageLog _messages;
};

} // namespace midair::bridge
