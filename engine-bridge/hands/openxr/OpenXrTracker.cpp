#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include "engine-bridge/hands/openxr/OpenXrSession.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// After this time without a call of latest() only events are handled, every kIdleInterval_s.
constexpr double kIdleAfter_s = 1.0;
constexpr double kIdleInterval_s = 0.1;

/// The longest pause between attempts. Pauses get longer since the loader writes to stderr whenever
/// a runtime can't be reached.
constexpr double kLongestRetry_s = 60.0;

/// A runtime isn't asked for what is farther ahead.
constexpr double kFarthest_s = 1.0;

/// Time to wait for another tracker to end, before the user gets a message that it has the runtime.
constexpr double kHandOver_s = 2.0;

/// When nobody has asked so far.
constexpr double kNever_s = -std::numeric_limits<double>::infinity();

bool isRecent(double asked_s)
{
    return base::steadySeconds() - asked_s < kIdleAfter_s;
}

/// A NaN counts as 0.
double horizonOf(double ahead_s)
{
    return ahead_s > 0.0 ? std::min(ahead_s, kFarthest_s) : 0.0;
}

auto after(double time_s)
{
    return std::chrono::steady_clock::now() + std::chrono::duration<double>(time_s);
}

/// The right to use the program's one OpenXR instance: one tracker has it at a time.
struct Turn
{
    base::Mutex mutex;
    base::Condition ended;
    bool taken MIDAIR_GUARDED_BY(mutex) = false;
};

Turn& turn()
{
    static Turn one;
    return one;
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
    _asked{kNever_s, kNever_s},
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
    {
        const base::Lock lock(turn().mutex);
        turn().ended.notifyAll();
    }
    _thread.join();
}

void OpenXrTracker::run()
{
    if (!takeTurn()) return;
    double retry_s = _options.retry_s;
    for (bool again = true; again && !_stop;)
    {
        if (followSession(again)) retry_s = _options.retry_s;
        base::Lock lock(_mutex);
        const auto end = after(retry_s);
        while (again && !_stop && _wake.waitUntil(lock, end))
        {
        }
        retry_s = std::max(retry_s, std::min(2.0 * retry_s, kLongestRetry_s));
    }
    const base::Lock lock(turn().mutex);
    turn().taken = false;
    turn().ended.notifyAll();
}

bool OpenXrTracker::followSession(bool& again)
{
    bool connected = false;
    try
    {
        OpenXrSession session(
            _options.loader, _options.space, [this](const std::string& message) { say(message); });
        connected = true;
        follow(session);
    }
    catch (const OpenXrError& error)
    {
        lose(error.what());
        again = error.mayPass();
    }
    return connected;
}

bool OpenXrTracker::takeTurn()
{
    Turn& mine = turn();
    base::Lock lock(mine.mutex);
    const auto end = after(kHandOver_s);
    while (!_stop && mine.taken && mine.ended.waitUntil(lock, end))
    {
    }
    if (!_stop && mine.taken)
        lose("openxr: another hand source of this program follows OpenXR with other options; no "
             "hands until it ends");
    while (!_stop && mine.taken)
        mine.ended.wait(lock);
    if (_stop) return false;
    mine.taken = true;
    return true;
}

void OpenXrTracker::follow(OpenXrSession& session)
{
    HandFrame frame;
    Head head;
    base::Lock lock(_mutex);
    while (!_stop)
    {
        const bool areHands = isRecent(_asked.hands_s);
        const bool isHead = isRecent(_asked.head_s);
        const bool asked = areHands || isHead;
        lock.unlock();
        session.handleEvents();
        frame.hands.clear();
        if (areHands) session.locate(frame, _horizon_s);
        head.isTracked = false;
        if (isHead) session.locateHead(head, _headHorizon_s);
        head.time_s = frame.time_s = base::steadySeconds();
        lock.lock();
        _leftOut = session.jointsLeftOut();
        _condition = "openxr: " + session.runtime() + (session.isRunning() ? "" : ", idle");
        if (areHands) _frame = frame;
        if (isHead) _head = head;
        if (areHands && !frame.hands.empty()) ++_frames;
        const auto end = after(asked ? kInterval_s : kIdleInterval_s);
        while (!_stop && (asked || !isAskedFor()) && _wake.waitUntil(lock, end))
        {
        }
    }
}

void OpenXrTracker::lose(const std::string& why)
{
    const base::Lock lock(_mutex);
    _frame.hands.clear();
    _head.isTracked = false;
    _condition = why;
    _messages.say({base::MessageCode::HANDS_SOURCE, why});
}

void OpenXrTracker::say(const std::string& message)
{
    const base::Lock lock(_mutex);
    _messages.say({base::MessageCode::HANDS_SOURCE, message});
}

bool OpenXrTracker::isAskedFor() const
{
    return isRecent(_asked.hands_s) || isRecent(_asked.head_s);
}

// Wakes the thread where it isn't looked for yet; returns the time.
double OpenXrTracker::noteAsked(double& asked_s)
{
    if (!isRecent(asked_s)) _wake.notifyAll();
    return asked_s = base::steadySeconds();
}

bool OpenXrTracker::latest(HandFrame& frame)
{
    const base::Lock lock(_mutex);
    const double now_s = noteAsked(_asked.hands_s);
    frame.hands.clear();
    if (now_s - _frame.time_s > kStale_s) return false;
    frame.hands = _frame.hands;
    for (Hand& hand : frame.hands)
        hand.age_s = now_s - _frame.time_s;
    return !frame.hands.empty();
}

bool OpenXrTracker::latestHead(Head& head)
{
    const base::Lock lock(_mutex);
    const double now_s = noteAsked(_asked.head_s);
    head = _head;
    head.age_s = std::max(0.0, now_s - _head.time_s);
    head.isTracked = _head.isTracked && head.age_s <= kStale_s;
    return head.isTracked;
}

void OpenXrTracker::setHorizon(double ahead_s)
{
    _horizon_s = horizonOf(ahead_s);
}

void OpenXrTracker::setHeadHorizon(double ahead_s)
{
    _headHorizon_s = horizonOf(ahead_s);
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
