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

/// An entry of the page's list of events.
struct MonitorEvent
{
    double time_s = 0.0; ///< steady clock, last occurrence
    std::string text;
    std::uint64_t count = 1; ///< consecutive occurrences
    bool isRoutine = false;  ///< comes with each touch; only the newest such event is kept
};

/// Count of a message code since the page started; never decreases.
struct MessageTotal
{
    osgMidair::HapticMessage::Severity severity = osgMidair::HapticMessage::NOTICE;
    std::uint64_t now = 0;   ///< in the newest reading
    std::uint64_t total = 0; ///< including evicted messages
};

/// The newest reading of an installation and its history. Times are of the steady clock.
struct MonitorView
{
    bool isRead = false; ///< false: no reading yet
    MonitorReading reading;
    double read_s = 0.0;  ///< time of the reading
    double frame_s = 0.0; ///< when the number of frames last changed
    double framesPerSecond = 0.0;
    double state_s = 0.0;                         ///< when the array entered its state
    bool isMuteKnown = false;                     ///< mute as last set or seen by this page
    std::string mutedBy;                          ///< who last muted or unmuted; empty: nobody
    double muted_s = 0.0;                         ///< time of that
    std::deque<MonitorEvent> events;              ///< newest first
    std::map<std::string, MessageTotal> messages; ///< by code
};

/// Result of a mute.
struct MuteOutcome
{
    bool isConfirmed = false;                                    ///< the array has confirmed it
    osgMidair::ArrayState state = osgMidair::ArrayState::CLOSED; ///< afterwards
    double took_ms = 0.0;                                        ///< time until then
};

/// Starts a thread that blocks the program's signals. The returned future is ready when \a body has
/// ended, and holds its exception. A thread that hangs is abandoned, so \a body must own what it
/// uses (std::shared_ptr). Throws std::system_error if no thread can be started.
std::future<void> startThread(std::function<void()> body);

/// Polls a source in a separate thread, so that a hanging source is noticed: its reading gets old.
class MonitorWatch : public std::enable_shared_from_this<MonitorWatch>
{
public:
    /// A reading older than this is not shown as current.
    static constexpr double kOld_s = 1.0;

    explicit MonitorWatch(std::shared_ptr<MonitorSource> source) : _source(std::move(source)) {}

    void begin();
    void end();

    MonitorView view() const;

    /// Mutes or unmutes at once, on this thread, and waits at most a second for the array to
    /// confirm it. \a who appears in the list of events.
    MuteOutcome setMuted(bool muted, const std::string& who);

    /// Adds an event.
    void note(const std::string& text);

private:
    void run();

    const std::shared_ptr<MonitorSource> _source;
    std::future<void> _reading;

    mutable base::Mutex _mutex; ///< never held while calling the source
    base::Condition _changed;
    MonitorView _view MIDAIR_GUARDED_BY(_mutex);
    std::uint64_t _mutesBegun MIDAIR_GUARDED_BY(_mutex) = 0; ///< mutes begun by the page ..
    std::uint64_t _mutesEnded MIDAIR_GUARDED_BY(_mutex) = 0; ///< .. and those already in the view
    bool _isStopped MIDAIR_GUARDED_BY(_mutex) = false;
};

} // namespace midair::samples
