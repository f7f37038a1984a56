#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include "engine-bridge/hands/openxr/OpenXrLending.h"
#include "engine-bridge/hands/openxr/OpenXrSession.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// After this time without a call of latest() only events are handled, every kIdleInterval_s.
constexpr double kIdleAfter_s = 1.0;
constexpr double kIdleInterval_s = 0.1;

/// Longest pause between attempts. Pauses grow, because the loader writes to stderr whenever a
/// runtime can't be reached.
constexpr double kLongestRetry_s = 60.0;

/// Longest requested prediction.
constexpr double kFarthest_s = 1.0;

/// Wait for another tracker to end, before the user gets a message that it has the runtime.
constexpr double kHandOver_s = 2.0;

bool isRecent(double asked_s)
{
    return base::steadySeconds() - asked_s < kIdleAfter_s;
}

/// NaN counts as 0.
double horizonOf(double ahead_s)
{
    return ahead_s > 0.0 ? std::min(ahead_s, kFarthest_s) : 0.0;
}

auto after(double time_s)
{
    return std::chrono::steady_clock::now() + std::chrono::duration<double>(time_s);
}

} // namespace

bool operator==(const OpenXrOptions& a, const OpenXrOptions& b)
{
    return a.loader == b.loader && a.space == b.space && a.retry_s == b.retry_s;
}

std::shared_ptr<OpenXrTracker> OpenXrTracker::open(const OpenXrOptions& options)
{
    static base::Mutex mutex;
    static std::weak_ptr<OpenXrTracker> last;
    const base::Lock lock(mutex);
    std::shared_ptr<OpenXrTracker> tracker = last.lock();
    if (tracker && tracker->_options == options) return tracker;
    tracker = std::make_shared<OpenXrTracker>(options);
    last = tracker;
    return tracker;
}

OpenXrTracker::OpenXrTracker(const OpenXrOptions& options) :
    _options(options),
    _thread([this] { run(); })
{
}

OpenXrTracker::~OpenXrTracker()
{
    _stop = true;
    {
        const base::Lock lock(_mutex);
        _wake.notifyAll();
    }
    OpenXrLending::one().wake();
    _thread.join();
}

void OpenXrTracker::run()
{
    while (!_stop)
    {
        if (OpenXrLending::one().isTaken())
            followLent();
        else if (takeTurn())
            connect();
    }
}

bool OpenXrTracker::takeTurn()
{
    OpenXrLending& lending = OpenXrLending::one();
    if (lending.beginOwn(kHandOver_s, _stop)) return true;
    if (_stop || lending.isTaken()) return false;
    lose("openxr: another hand source of this program follows OpenXR with other options; no "
         "hands until it ends");
    return lending.beginOwn(-1.0, _stop);
}

// Follows its own sessions until it has to end or to follow a lent one.
void OpenXrTracker::connect()
{
    OpenXrLending& lending = OpenXrLending::one();
    double retry_s = _options.retry_s;
    bool again = true;
    while (again && !_stop && !lending.isTaken())
    {
        if (followSession(again)) retry_s = _options.retry_s;
        if (again) pause(retry_s, false);
        retry_s = std::max(retry_s, std::min(2.0 * retry_s, kLongestRetry_s));
    }
    lending.endOwn();
    while (!again && !_stop && !lending.isTaken())
        pause(kLongestRetry_s, false);
}

/// Waits for \a time_s, until the end, or until lending differs from \a isTaken.
void OpenXrTracker::pause(double time_s, bool isTaken)
{
    const double end_s = base::steadySeconds() + time_s;
    base::Lock lock(_mutex);
    for (double now_s = base::steadySeconds();
         !_stop && now_s < end_s && OpenXrLending::one().isTaken() == isTaken;
         now_s = base::steadySeconds())
        _wake.waitUntil(lock, after(std::min(kIdleInterval_s, end_s - now_s)));
}

bool OpenXrTracker::followSession(bool& again)
{
    bool connected = false;
    try
    {
        OpenXrSession session(
            _options.loader, _options.space, [this](const std::string& message) { say(message); });
        connected = true;
        follow(&session);
    }
    catch (const OpenXrError& error)
    {
        lose(error.what());
        again = error.mayPass();
    }
    return connected;
}

void OpenXrTracker::followLent()
{
    try
    {
        follow(nullptr);
    }
    catch (const OpenXrError& error)
    {
        lose(error.what()); // its owner looks for another
        pause(kIdleInterval_s, true);
    }
}

/// Data for an asker.
struct OpenXrTracker::Reading
{
    HandFrame frame;
    Head head;
};

OpenXrTracker::Askers OpenXrTracker::recentAskers()
{
    Askers recent;
    _askers.erase(std::remove_if(_askers.begin(),
                                 _askers.end(),
                                 [](const auto& asker) { return asker.expired(); }),
                  _askers.end());
    for (const std::weak_ptr<OpenXrAsker>& one : _askers)
        if (auto asker = one.lock(); asker && isRecent(asker->asked_s))
            recent.push_back(std::move(asker));
    _isWanted = false;
    return recent;
}

void OpenXrTracker::publish(Askers& askers, const std::vector<Reading>& read)
{
    bool any = false;
    const double now_s = base::steadySeconds();
    for (std::size_t i = 0; i < askers.size(); ++i)
    {
        askers[i]->frame = read[i].frame;
        askers[i]->head = read[i].head;
        askers[i]->frame.time_s = askers[i]->head.time_s = now_s;
        any = any || !read[i].frame.hands.empty();
    }
    if (any) ++_frames;
}

void OpenXrTracker::follow(OpenXrSession* own)
{
    OpenXrLending& lending = OpenXrLending::one();
    base::Lock lock(_mutex);
    while (!_stop && lending.isTaken() == !own)
    {
        Askers askers = recentAskers();
        lock.unlock();
        std::string condition = "openxr: no session of the headset or of the program now";
        std::size_t leftOut = 0;
        std::vector<Reading> read(askers.size());
        const auto readIn = [&](OpenXrSession& session)
        {
            for (std::size_t i = 0; i < askers.size(); ++i)
                if (askers[i]->isForHead)
                    session.locateHead(read[i].head, askers[i]->horizon_s);
                else
                    session.locate(read[i].frame, askers[i]->horizon_s);
            leftOut = session.jointsLeftOut();
            condition = "openxr: " + session.runtime() + (session.isRunning() ? "" : ", idle");
        };
        if (own)
        {
            own->handleEvents();
            readIn(*own);
        }
        else
        {
            lending.use(readIn);
            for (const std::string& message : lending.messages(_lentTold))
                say(message);
        }
        lock.lock();
        _leftOut = leftOut;
        _condition = condition;
        publish(askers, read);
        const auto end = after(askers.empty() ? kIdleInterval_s : kInterval_s);
        while (!_stop && (!askers.empty() || !_isWanted) && _wake.waitUntil(lock, end))
        {
        }
    }
}

void OpenXrTracker::lose(const std::string& why)
{
    const base::Lock lock(_mutex);
    for (const std::weak_ptr<OpenXrAsker>& one : _askers)
        if (const auto asker = one.lock())
        {
            asker->frame.hands.clear();
            asker->head.isTracked = false;
        }
    _condition = why;
    _messages.say({base::MessageCode::HANDS_SOURCE, why});
}

void OpenXrTracker::say(const std::string& message)
{
    const base::Lock lock(_mutex);
    _messages.say({base::MessageCode::HANDS_SOURCE, message});
}

std::shared_ptr<OpenXrAsker> OpenXrTracker::newAsker(bool forHead)
{
    auto asker = std::make_shared<OpenXrAsker>(forHead);
    const base::Lock lock(_mutex);
    _askers.push_back(asker);
    return asker;
}

// Wakes the thread if this is the first request; returns the time.
double OpenXrTracker::noteAsked(double& asked_s)
{
    if (!isRecent(asked_s))
    {
        _isWanted = true;
        _wake.notifyAll();
    }
    return asked_s = base::steadySeconds();
}

bool OpenXrTracker::latest(OpenXrAsker& asker, HandFrame& frame)
{
    const base::Lock lock(_mutex);
    const double now_s = noteAsked(asker.asked_s);
    frame.hands.clear();
    if (now_s - asker.frame.time_s > kStale_s) return false;
    frame.hands = asker.frame.hands;
    for (Hand& hand : frame.hands)
        hand.age_s = now_s - asker.frame.time_s;
    return !frame.hands.empty();
}

bool OpenXrTracker::latestHead(OpenXrAsker& asker, Head& head)
{
    const base::Lock lock(_mutex);
    const double now_s = noteAsked(asker.asked_s);
    head = asker.head;
    head.age_s = std::max(0.0, now_s - asker.head.time_s);
    head.isTracked = asker.head.isTracked && head.age_s <= kStale_s;
    return head.isTracked;
}

void OpenXrTracker::setHorizon(OpenXrAsker& asker, double ahead_s)
{
    asker.horizon_s = horizonOf(ahead_s);
}

std::vector<std::string> OpenXrTracker::messages(std::size_t& told) const
{
    const base::Lock lock(_mutex);
    return _messages.newTexts(told);
}

std::string OpenXrTracker::status() const
{
    const base::Lock lock(_mutex);
    return fmt::format(
        "{}; {} frames with hands, {} joints left out", _condition, _frames, _leftOut);
}

} // namespace midair::bridge
