#pragma once

#include "samples/shared/monitor/MonitorSource.h"
#include "samples/shared/monitor/page/PatientThreads.h"

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>

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

/// Reads a source again and again, in a thread of its own, so that one that hangs is seen to do so:
/// its reading grows old, and whoever shows it can tell.
class MonitorWatch
{
public:
    /// A reading that is older is not what is.
    static constexpr double kOld_s = 1.0;

    explicit MonitorWatch(std::shared_ptr<MonitorSource> source);
    ~MonitorWatch();
    MonitorWatch(const MonitorWatch&) = delete;
    MonitorWatch& operator=(const MonitorWatch&) = delete;

    MonitorView view() const;

    /// Mutes or unmutes at once, on this thread, and waits for the array to say so, for at most a
    /// second. \a who is told in the list of events.
    MuteOutcome setMuted(bool muted, const std::string& who);

    /// Adds to the list of events.
    void note(const std::string& text);

private:
    struct Shared;
    static void run(const std::shared_ptr<Shared>& shared);

    std::shared_ptr<Shared> _shared;
    PatientThreads _threads;
};

} // namespace midair::samples
