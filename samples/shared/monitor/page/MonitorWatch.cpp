#include "samples/shared/monitor/page/MonitorWatch.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <csignal>
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

// Changes between silent and playing are routine, so they must not push out other events.
void addRoutine(MonitorView& view, double time_s, const std::string& text)
{
    MonitorEvent event{time_s, text, 1, true};
    const auto last = std::find_if(view.events.begin(),
                                   view.events.end(),
                                   [](const MonitorEvent& one) { return one.isRoutine; });
    if (last != view.events.end())
    {
        event.count += last->count;
        view.events.erase(last);
    }
    view.events.push_front(std::move(event));
    if (view.events.size() > kMostEvents) view.events.pop_back();
}

bool isUsual(osgMidair::ArrayState state)
{
    using osgMidair::ArrayState;
    return state == ArrayState::SILENT || state == ArrayState::PLAYING ||
           state == ArrayState::MUTED;
}

/// Returns the state in an operator's words.
std::string toldOf(osgMidair::ArrayState state)
{
    constexpr const char* kTold[] = {"no array is connected",
                                     "connecting to the array",
                                     "the array is ready; nothing to play",
                                     "the array is playing",
                                     "the array is muted",
                                     "the array is unplugged or has failed",
                                     "the array doesn't respond to commands"};
    return kTold[static_cast<int>(state)];
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

/// Adds a reading that began at \a time_s. \a isOurMute: the page itself was muting or unmuting, so
/// the mute is not somebody else's.
void takeReading(MonitorView& view, MonitorReading reading, double time_s, bool isOurMute)
{
    const osgMidair::HapticStatistics& now = reading.statistics;
    const osgMidair::HapticStatistics& last = view.reading.statistics;
    if (!view.isRead || now.frames != last.frames)
    {
        const double gone_s = time_s - view.frame_s;
        const auto frames = static_cast<double>(now.frames - last.frames);
        // Averages over about a second.
        if (view.isRead && gone_s > 0.0)
            view.framesPerSecond +=
                (frames / gone_s - view.framesPerSecond) * std::min(1.0, gone_s / 1.0);
        view.frame_s = time_s;
    }
    if (!view.isRead || now.state != last.state)
    {
        view.state_s = time_s;
        const bool isRoutine = view.isRead && isUsual(last.state) && isUsual(now.state);
        (isRoutine ? addRoutine : addEvent)(view, time_s, toldOf(now.state));
    }
    if (view.isRead && !isOurMute && reading.isMuted != view.isMuteKnown)
    {
        view.mutedBy = "a key, a switch or the program";
        view.muted_s = time_s;
        addEvent(view,
                 time_s,
                 fmt::format("{} by {}", reading.isMuted ? "muted" : "unmuted", view.mutedBy));
    }
    if (!isOurMute) view.isMuteKnown = reading.isMuted;
    countMessages(view, now);
    view.reading = std::move(reading);
    view.read_s = time_s;
    view.isRead = true;
}

/// Returns true if an array in \a state follows the request.
bool isAsAsked(osgMidair::ArrayState state, bool muted)
{
    using osgMidair::ArrayState;
    if (!muted) return state != ArrayState::MUTED;
    return state == ArrayState::MUTED || state == ArrayState::CLOSED;
}

} // namespace

std::future<void> startThread(std::function<void()> body)
{
    std::promise<void> promise;
    std::future<void> ended = promise.get_future();
    auto run = [body = std::move(body), promise = std::move(promise)]() mutable
    {
        // Blocks all signals except those of a crash, on which the program may silence the array.
        sigset_t all;
        ::sigfillset(&all);
        for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
            ::sigdelset(&all, crash);
        ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
        std::exception_ptr thrown;
        try
        {
            body();
        }
        catch (...)
        {
            thrown = std::current_exception();
        }
        body = nullptr; // free its captures before reporting
        if (thrown)
            promise.set_exception(thrown);
        else
            promise.set_value();
    };
    std::thread(std::move(run)).detach();
    return ended;
}

void MonitorWatch::begin()
{
    _reading = startThread([self = shared_from_this()] { self->run(); });
}

void MonitorWatch::end()
{
    {
        const base::Lock lock(_mutex);
        _isStopped = true;
    }
    _changed.notifyAll();
    if (_reading.wait_for(std::chrono::seconds(2)) != std::future_status::ready)
        std::fprintf(stderr, "the operator's page: reading the scene hangs and is abandoned\n");
}

void MonitorWatch::run()
{
    base::Lock lock(_mutex);
    while (!_isStopped)
    {
        const std::uint64_t begun = _mutesBegun;
        const bool isUnderWay = begun != _mutesEnded;
        const double begin_s = base::steadySeconds();
        lock.unlock();
        MonitorReading reading;
        std::string problem;
        try
        {
            reading = _source->read();
        }
        catch (const std::exception& error)
        {
            problem = error.what();
        }
        lock.lock();
        // A mute by the page during this reading is reported by setMuted().
        if (problem.empty())
            takeReading(_view, std::move(reading), begin_s, isUnderWay || begun != _mutesBegun);
        else
            addEvent(_view, begin_s, "the scene can't be read: " + problem);
        const double next_s = base::steadySeconds() + kInterval_s;
        while (!_isStopped && _changed.waitUntil_s(lock, next_s))
        {
        }
    }
}

MonitorView MonitorWatch::view() const
{
    const base::Lock lock(_mutex);
    return _view;
}

MuteOutcome MonitorWatch::setMuted(bool muted, const std::string& who)
{
    {
        const base::Lock lock(_mutex);
        ++_mutesBegun;
    }
    const double begin_s = base::steadySeconds();
    try
    {
        _source->setMuted(muted);
    }
    catch (...) // the page's mute has ended; later changes are somebody else's
    {
        const base::Lock lock(_mutex);
        ++_mutesEnded;
        throw;
    }
    const std::string told = fmt::format("{} by {}", muted ? "muted" : "unmuted", who);
    {
        const base::Lock lock(_mutex);
        ++_mutesEnded;
        _view.isMuteKnown = muted;
        _view.mutedBy = who;
        _view.muted_s = base::steadySeconds();
        addEvent(_view, _view.muted_s, told);
    }
    std::fprintf(stderr, "the operator's page: %s\n", told.c_str());
    for (;;)
    {
        const osgMidair::ArrayState state = _source->read().statistics.state;
        const double took_s = base::steadySeconds() - begin_s;
        if (isAsAsked(state, muted) || took_s > kMuteWait_s)
            return {isAsAsked(state, muted), state, 1e3 * took_s};
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

void MonitorWatch::note(const std::string& text)
{
    const base::Lock lock(_mutex);
    addEvent(_view, base::steadySeconds(), text);
}

} // namespace midair::samples
