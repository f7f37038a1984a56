#include "engine-bridge/player/SceneMessages.h"

#include "haptics/base/text/Words.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

// \a isCounted: it is said once more; else it is one that the thread has counted.
void SceneMessages::keep(base::Message message, bool isCounted)
{
    message.text = base::printable(message.text); // may contain text from a file
    message.path = base::printable(message.path);
    bool fresh = false;
    {
        const base::Lock lock(_mutex);
        fresh = isCounted ? _log.say(message) : _log.take(message);
    }
    if (!fresh || !_print) return;
    if (const auto line = _lines.take(message, base::steadySeconds())) _print(*line);
}

// A result has all that its thread has told so far. What was taken before may be gone from the log,
// which has a limit, and isn't new for that.
void SceneMessages::take(const std::vector<base::Message>& told)
{
    std::uint64_t newest = _takenUpTo;
    for (const base::Message& message : told)
    {
        if (message.said == 0 || message.said > _takenUpTo) keep(message, false);
        newest = std::max(newest, message.said);
    }
    _takenUpTo = newest;
}

void SceneMessages::printDue(double now_s)
{
    for (const Line& line : _lines.due(now_s))
        _print(line);
}

std::vector<base::Message> SceneMessages::all() const
{
    const base::Lock lock(_mutex);
    return _log.messages();
}

} // namespace midair::bridge
