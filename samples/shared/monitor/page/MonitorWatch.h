#pragma once

#include "haptics/base/threads/Mutex.h"
#include "samples/shared/monitor/Monitor.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace midair::samples
{

/// Something that happened, for the list on the page.
struct MonitorEvent
{
    double time_s = 0.0; ///< steady clock, the last time
    std::string text;
    std::uint64_t count = 1; ///< times in a row
};

/// How often messages of one code were said, since the page is served; never less than before.
struct MessageTotal
{
    osgMidair::HapticMessage::Severity severity = osgMidair::HapticMessage::NOTICE;
    std::uint64_t now = 0;   ///< those in the newest reading
    std::uint64_t total = 0; ///< with those that have made room for others
};

/// The newest reading of an installation, and what was seen over time. Times are of the steady
/// clock.
struct MonitorView
{
    bool isRead = false; ///< false: nothing was read yet
    MonitorReading reading;
    double read_s = 0.0;  ///< when it was read
    double frame_s = 0.0; ///< when the number of frames was last seen to change
    double framesPerSecond = 0.0;
    double state_s = 0.0;                         ///< since when the array is in its state
    bool isMuteKnown = false;                     ///< muted as far as this page has done or seen it
    std::string mutedBy;                          ///< who muted or unmuted last; empty: nobody has
    double muted_s = 0.0;                         ///< when
    std::deque<MonitorEvent> events;              ///< the newest first
    std::map<std::string, MessageTotal> messages; ///< by code
};

/// How a mute went.
struct MuteOutcome
{
    bool isConfirmed = false; ///< the array says that it is silent, or that it is muted no more
    osgMidair::ArrayState state = osgMidair::ArrayState::CLOSED; ///< afterwards
    double took_ms = 0.0;                                        ///< until it said so
};

/// Starts a thread that takes none of the program's signals. What is returned is ready once
/// \a body has ended, and tells what it has thrown. Whoever waits for it in vain leaves the thread
/// behind: what \a body uses must belong to it, too (std::shared_ptr). Throws std::system_error if
/// there is no thread left.
std::future<void> startThread(std::function<void()> body);

/// Reads a source again and again, in a thread of its own, so that one that hangs is seen to do so:
/// its reading grows old, and whoever shows it can tell.
class MonitorWatch : public std::enable_shared_from_this<MonitorWatch>
{
public:
    /// A reading that is older is not what is.
    static constexpr double kOld_s = 1.0;

    explicit MonitorWatch(std::shared_ptr<MonitorSource> source) : _source(std::move(source)) {}

    void begin();
    void end();

    MonitorView view() const;

    /// Mutes or unmutes at once, on this thread, and waits for the array to say so, for at most a
    /// second. \a who is told in the list of events.
    MuteOutcome setMuted(bool muted, const std::string& who);

    /// Adds to the list of events.
    void note(const std::string& text);

private:
    void run();

    const std::shared_ptr<MonitorSource> _source;
    std::future<void> _reading;

    mutable base::Mutex _mutex; ///< never held while the source is called
    base::Condition _changed;
    MonitorView _view MIDAIR_GUARDED_BY(_mutex);
    std::uint64_t _mutesBegun MIDAIR_GUARDED_BY(_mutex) = 0; ///< that the page has asked for ..
    std::uint64_t _mutesEnded MIDAIR_GUARDED_BY(_mutex) = 0; ///< .. and that are told in the view
    bool _isStopped MIDAIR_GUARDED_BY(_mutex) = false;
};

} // namespace midair::samples
