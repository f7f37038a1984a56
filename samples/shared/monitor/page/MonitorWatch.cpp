#include "samples/shared/monitor/page/MonitorWatch.h"

#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <exception>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kInterval_s = 0.1;
constexpr std::size_t kMostEvents = 30;
constexpr double kMuteWait_s = 1.0;

void addEvent(MonitorView& view, double time_s, const std::string& text)
{
    if (!view.events.empty() && view.events.front().text == text)
    {
        ++view.events.front().count;
        view.events.front().time_s = time_s;
        return;
    }
    view.events.push_front({time_s, text, 1});
    if (view.events.size() > kMostEvents) view.events.pop_back();
}

void countMessages(MonitorView& view, const osgMidair::HapticStatistics& statistics)
{
    std::map<std::string, std::uint64_t> counts;
    for (const osgMidair::HapticMessage& message : statistics.told)
    {
        counts[message.code] += message.count;
        view.messages[message.code].severity = message.severity;
    }
    for (auto& [code, total] : view.messages)
    {
        const std::uint64_t count = counts[code];
        if (count > total.now) total.total += count - total.now;
        total.now = count;
    }
}

/// Takes a reading that was begun at \a begin_s and is there at \a time_s. \a isOurMute: the page
/// has muted or unmuted meanwhile, so that no other has.
void takeReading(MonitorView& view, MonitorReading reading, double time_s, bool isOurMute)
{
    const osgMidair::HapticStatistics& now = reading.statistics;
    const osgMidair::HapticStatistics& last = view.reading.statistics;
    if (!view.isRead || now.frames != last.frames)
    {
        const double gone_s = time_s - view.frame_s;
        const auto frames = static_cast<double>(now.frames - last.frames);
        // Over about a second, so that single frames don't make it jump.
        if (view.isRead && gone_s > 0.0)
            view.framesPerSecond +=
                (frames / gone_s - view.framesPerSecond) * std::min(1.0, gone_s / 1.0);
        view.frame_s = time_s;
    }
    if (!view.isRead || now.state != last.state)
    {
        view.state_s = time_s;
        addEvent(view,
                 time_s,
                 view.isRead
                     ? fmt::format("the array was {}, is {}",
                                   midair::bridge::stateName(last.state),
                                   midair::bridge::stateName(now.state))
                     : fmt::format("the array is {}", midair::bridge::stateName(now.state)));
    }
    const bool isOthers = view.isRead && !isOurMute && reading.isMuted != view.isMuteKnown;
    if (!isOurMute) view.isMuteKnown = reading.isMuted;
    if (isOthers)
    {
        view.mutedBy = "a key, a switch or the program";
        view.muted_s = time_s;
        addEvent(view,
                 time_s,
                 fmt::format("{} by {}", reading.isMuted ? "muted" : "unmuted", view.mutedBy));
    }
    countMessages(view, now);
    view.reading = std::move(reading);
    view.read_s = time_s;
    view.isRead = true;
}

/// Returns true if an array in \a state does what was asked for.
bool isAsAsked(osgMidair::ArrayState state, bool muted)
{
    using osgMidair::ArrayState;
    if (!muted) return state != ArrayState::MUTED;
    return state == ArrayState::MUTED || state == ArrayState::CLOSED;
}

} // namespace

struct MonitorWatch::Shared
{
    std::shared_ptr<MonitorSource> source;
    mutable base::Mutex mutex; ///< never held while the source is called
    base::Condition changed;
    MonitorView view MIDAIR_GUARDED_BY(mutex);
    std::uint64_t mutes MIDAIR_GUARDED_BY(mutex) = 0;      ///< that the page has asked for ..
    std::uint64_t mutesBegun MIDAIR_GUARDED_BY(mutex) = 0; ///< .. counted before each, too
    bool isStopped MIDAIR_GUARDED_BY(mutex) = false;
};

MonitorWatch::MonitorWatch(std::shared_ptr<MonitorSource> source) :
    _shared(std::make_shared<Shared>())
{
    _shared->source = std::move(source);
    _threads.start("the operator's page: its watch", [shared = _shared] { run(shared); });
}

MonitorWatch::~MonitorWatch()
{
    {
        const base::Lock lock(_shared->mutex);
        _shared->isStopped = true;
    }
    _shared->changed.notifyAll();
    if (!_threads.finish(2.0))
        std::fprintf(stderr,
                     "the operator's page: reading the scene hangs; it is left to itself\n");
}

void MonitorWatch::run(const std::shared_ptr<Shared>& shared)
{
    base::Lock lock(shared->mutex);
    while (!shared->isStopped)
    {
        const std::uint64_t mutes = shared->mutes;
        const std::uint64_t begun = shared->mutesBegun;
        const double begin_s = base::steadySeconds();
        lock.unlock();
        MonitorReading reading;
        std::string problem;
        try
        {
            reading = shared->source->read();
        }
        catch (const std::exception& error)
        {
            problem = error.what();
        }
        lock.lock();
        // A mute of ours that was under way during this reading is told by setMuted().
        const bool isOurs = begun != mutes || shared->mutesBegun != begun;
        if (problem.empty())
            takeReading(shared->view, std::move(reading), begin_s, isOurs);
        else
            addEvent(shared->view, begin_s, "the scene can't be read: " + problem);
        const double next_s = base::steadySeconds() + kInterval_s;
        while (!shared->isStopped && shared->changed.waitUntil_s(lock, next_s))
        {
        }
    }
}

MonitorView MonitorWatch::view() const
{
    const base::Lock lock(_shared->mutex);
    return _shared->view;
}

MuteOutcome MonitorWatch::setMuted(bool muted, const std::string& who)
{
    {
        const base::Lock lock(_shared->mutex);
        ++_shared->mutesBegun;
    }
    const double begin_s = base::steadySeconds();
    try
    {
        _shared->source->setMuted(muted);
    }
    catch (...) // it is over all the same: what others mute is theirs
    {
        const base::Lock lock(_shared->mutex);
        ++_shared->mutes;
        throw;
    }
    {
        const base::Lock lock(_shared->mutex);
        ++_shared->mutes;
        _shared->view.isMuteKnown = muted;
        _shared->view.mutedBy = who;
        _shared->view.muted_s = base::steadySeconds();
        addEvent(_shared->view,
                 base::steadySeconds(),
                 fmt::format("{} by {}", muted ? "muted" : "unmuted", who));
    }
    std::fprintf(
        stderr, "the operator's page: %s by %s\n", muted ? "muted" : "unmuted", who.c_str());
    MuteOutcome outcome;
    for (;;)
    {
        outcome.state = _shared->source->read().statistics.state;
        outcome.took_ms = 1e3 * (base::steadySeconds() - begin_s);
        outcome.isConfirmed = isAsAsked(outcome.state, muted);
        if (outcome.isConfirmed || outcome.took_ms > 1e3 * kMuteWait_s) return outcome;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

void MonitorWatch::note(const std::string& text)
{
    const base::Lock lock(_shared->mutex);
    addEvent(_shared->view, base::steadySeconds(), text);
}

} // namespace midair::samples
