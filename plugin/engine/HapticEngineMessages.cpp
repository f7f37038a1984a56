// What a HapticEngine tells: its own messages and those of its thread.
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/settings/Grants.h"

#include <osg/Notify>

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

using midair::base::LineLimit;
using midair::base::Message;
using midair::base::MessageCode;

namespace
{

/// A solver that takes longer for one field, while the scene moves on, is told.
constexpr double kSlowSolve_s = 1.0;
/// A solver that hasn't been slow for this long is told again when it is.
constexpr double kSlowOver_s = 5.0;

void notify(const LineLimit::Line& line)
{
    const bool isNotice = line.severity == midair::base::Severity::NOTICE;
    osg::notify(isNotice ? osg::NOTICE : osg::WARN) << "osgMidair: " << line.text << std::endl;
}

} // namespace

// A callback may do anything, so this comes last.
void HapticEngine::tellState()
{
    DeviceChange change;
    change.before = _stateTold;
    change.now = _thread ? _thread->state() : ArrayState::CLOSED;
    if (change.now == change.before) return;
    _stateTold = change.now;
    change.status = _thread ? _thread->deviceStatus() : "";
    const auto isTrouble = [](ArrayState state)
    { return state == ArrayState::LOST || state == ArrayState::FAULT; };
    const bool isNews = isTrouble(change.before) || isTrouble(change.now);
    osg::notify(isNews ? osg::NOTICE : osg::INFO)
        << "osgMidair: the array is " << midair::bridge::stateName(change.now) << " (it was "
        << midair::bridge::stateName(change.before) << "): " << printable(change.status)
        << std::endl;
    const osg::ref_ptr<DeviceCallback> keep = _deviceCallback;
    if (!keep) return;
    const std::string thrown = midair::base::thrownBy([&] { keep->changed(change); });
    if (!thrown.empty())
        say({MessageCode::CALLBACK_THREW, "the device callback has thrown " + thrown});
}

void HapticEngine::say(Message message)
{
    keep(std::move(message), true);
}

// \a isCounted: it is said once more; else it is one that the thread has counted.
void HapticEngine::keep(Message message, bool isCounted)
{
    message.text = printable(message.text); // may contain text from a file
    message.path = printable(message.path);
    bool fresh = false;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        fresh = isCounted ? _messages.say(message) : _messages.take(message);
    }
    if (!fresh) return;
    if (const auto line = _lines.take(message, midair::base::steadySeconds())) notify(*line);
}

void HapticEngine::tellLines(double now_s)
{
    for (const LineLimit::Line& line : _lines.due(now_s))
        notify(line);
}

// A result has all that its thread has told so far. What was taken before may be gone from the log,
// which has a limit, and isn't new for that.
void HapticEngine::takeMessages(const midair::bridge::HologramResult& result)
{
    std::uint64_t newest = _takenUpTo;
    for (const Message& message : result.told)
    {
        const bool isNew = message.said == 0 || message.said > _takenUpTo;
        // The grants have told of a refused array already, with what to do.
        const bool isTold = _isArrayRefused && message.code == MessageCode::ARRAY_REFUSED;
        if (isNew && !isTold) keep(message, false);
        newest = std::max(newest, message.said);
    }
    _takenUpTo = newest;
}

// A solver of the program's own may take as long as it likes, and its thread can't tell meanwhile.
void HapticEngine::tellSlowSolver(double now_s)
{
    const double taken_s = _thread ? _thread->solvesFor_s() : 0.0;
    if (taken_s <= kSlowSolve_s)
    {
        if (now_s > _slowUntil_s) _slowUntil_s = 0.0;
        return;
    }
    const bool isTold = _slowUntil_s > 0.0;
    _slowUntil_s = now_s + kSlowOver_s;
    if (isTold) return;
    const bool isHeard = _seen && _seen->playing && !_submitted.empty();
    say({MessageCode::SOLVER_SLOW,
         fmt::format("the solver has taken {:.1f} s for one field and is still at it; {}",
                     taken_s,
                     isHeard ? fmt::format("what is played is of frame {}", _seen->frame)
                             : "nothing is played meanwhile")});
}

// A scene that plays has one of the process's places; one without opens nothing.
void HapticEngine::takePlace()
{
    const bool isWanted = _settings.enabled && !_isBaked;
    _isCrowded = isWanted && !_place.take();
    if (!isWanted && !_thread) _place.leave();
    if (!_isCrowded) return;
    _settings.enabled = _granted.enabled = false;
    say({MessageCode::SCENE_LIMIT,
         fmt::format("{} is not played: {} scenes of this program play already, and no more do at "
                     "a time; put those that share an array into one HapticScene",
                     name(),
                     PlayingPlace::kMost)});
}

} // namespace osgMidair
