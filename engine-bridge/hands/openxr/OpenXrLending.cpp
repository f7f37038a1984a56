#include "engine-bridge/hands/openxr/OpenXrLending.h"

#include "haptics/base/threads/SteadyClock.h"

#include <chrono>

namespace midair::bridge
{

namespace
{

/// Longest wait of take() for a tracker's call to the runtime.
constexpr double kTake_s = 5.0;
/// After this time the display counts as inactive.
constexpr double kShown_s = 0.2;

auto inSeconds(double time_s)
{
    return std::chrono::steady_clock::now() + std::chrono::duration<double>(time_s);
}

} // namespace

OpenXrLending& OpenXrLending::one()
{
    // Never destroyed, because threads of trackers may outlive static objects.
    static auto* const all = new OpenXrLending;
    return *all;
}

std::string OpenXrLending::take()
{
    base::Lock lock(_mutex);
    if (_isTaken.exchange(true))
        return "this program has a session already, its own or a headset's view, and OpenXR allows "
               "one";
    _changed.notifyAll();
    const auto end = inSeconds(kTake_s);
    while (_isOwn && _changed.waitUntil(lock, end))
    {
    }
    if (!_isOwn) return {};
    _isTaken = false;
    _changed.notifyAll();
    return "the runtime doesn't answer the kit's tracker, which has the program's one instance";
}

void OpenXrLending::give()
{
    lend(nullptr);
    const base::Lock lock(_mutex);
    _isTaken = false;
    _changed.notifyAll();
}

void OpenXrLending::lend(OpenXrSession* session)
{
    const base::Lock lock(_using);
    _session = session;
}

bool OpenXrLending::use(const std::function<void(OpenXrSession&)>& use)
{
    const base::Lock lock(_using);
    if (!_session) return false;
    use(*_session);
    return true;
}

void OpenXrLending::say(const std::string& message)
{
    _messages.say({base::MessageCode::HANDS_SOURCE, message});
}

void OpenXrLending::show(const HandFrame& frame)
{
    const base::Lock lock(_mutex);
    _shown = frame;
    _shown.time_s = base::steadySeconds();
}

bool OpenXrLending::shown(HandFrame& frame) const
{
    const base::Lock lock(_mutex);
    if (!_isTaken || base::steadySeconds() - _shown.time_s > kShown_s) return false;
    frame.hands = _shown.hands;
    return true;
}

std::string OpenXrLending::recentred() const
{
    const base::Lock lock(_mutex);
    return _recentred;
}

void OpenXrLending::setRecentred(const std::string& why)
{
    const base::Lock lock(_mutex);
    _recentred = why;
}

bool OpenXrLending::beginOwn(double patience_s, const std::atomic<bool>& stop)
{
    base::Lock lock(_mutex);
    const auto end = inSeconds(patience_s);
    while (_isOwn && !_isTaken && !stop)
    {
        if (patience_s < 0.0)
            _changed.wait(lock);
        else if (!_changed.waitUntil(lock, end))
            break;
    }
    if (_isOwn || _isTaken || stop) return false;
    _isOwn = true;
    return true;
}

void OpenXrLending::endOwn()
{
    const base::Lock lock(_mutex);
    _isOwn = false;
    _changed.notifyAll();
}

void OpenXrLending::wake()
{
    const base::Lock lock(_mutex);
    _changed.notifyAll();
}

} // namespace midair::bridge
