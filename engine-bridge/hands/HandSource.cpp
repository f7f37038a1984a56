#include "engine-bridge/hands/HandSource.h"

#include "engine-bridge/hands/HandRecording.h"
#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <sstream>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

// A line of 30 bytes makes a hand of 2,000 bytes, so limiting the file's size is not enough.
constexpr std::size_t kMostHandsInAll = 200000;
constexpr std::size_t kMostHandsInFrame = 8;

/// The frame's hand with that id, or null.
Hand* handOf(HandFrame& frame, int id)
{
    for (Hand& hand : frame.hands)
        if (hand.id == id) return &hand;
    return nullptr;
}

/// Interpolates a joint; it is valid if it is valid in both frames.
HandJoint between(const HandJoint& a, const HandJoint& b, double share)
{
    HandJoint joint;
    joint.positionValid = a.positionValid && b.positionValid;
    joint.orientationValid = a.orientationValid && b.orientationValid;
    joint.position = (1.0 - share) * a.position + share * b.position;
    if (joint.orientationValid) joint.orientation = a.orientation.slerp(share, b.orientation);
    joint.radius_m = (1.0 - share) * a.radius_m + share * b.radius_m;
    return joint;
}

HandFrame between(const HandFrame& a, const HandFrame& b, double share)
{
    HandFrame frame;
    for (const Hand& before : a.hands)
        for (const Hand& after : b.hands)
        {
            if (before.id != after.id) continue;
            Hand hand;
            hand.id = before.id;
            for (std::size_t i = 0; i < HAND_JOINTS; ++i)
                hand.joints[i] = between(before.joints[i], after.joints[i], share);
            frame.hands.push_back(hand);
        }
    return frame;
}

} // namespace

RecordedHandSource::RecordedHandSource(const std::string& path, bool loop) :
    _name(path),
    _loop(loop)
{
    std::istringstream in(recordingIn(path));
    read(in);
}

RecordedHandSource::RecordedHandSource(std::istream& in, const std::string& name, bool loop) :
    _name(name),
    _loop(loop)
{
    read(in);
}

void RecordedHandSource::read(std::istream& in)
{
    std::size_t hands = 0;
    readRecording(in, _name, [&](const RecordedRow& row) { return take(row, hands); });
    if (_frames.empty())
        throw base::InputError(_name + ": no hand joints in it; a line is " + kRecordedHeadings);
}

// Returns the error of the row, or an empty text. Ignores heads.
std::string RecordedHandSource::take(const RecordedRow& row, std::size_t& hands)
{
    if (row.joint == RecordedRow::kHead) return {};
    if (!_frames.empty() && row.time_s < _frames.back().time_s)
        return fmt::format("time {:g} is before the line above it", row.time_s);
    const bool isNew = _frames.empty() || row.time_s > _frames.back().time_s;
    Hand* hand = isNew ? nullptr : handOf(_frames.back(), row.hand);
    if (isNew && _frames.size() == kMostRecordedFrames)
        return "more than 200000 frames, which are the most possible";
    if (!hand && !isNew && _frames.back().hands.size() == kMostHandsInFrame)
        return "more than 8 hands at one time, which are the most possible";
    if (!hand && hands == kMostHandsInAll)
        return "more than 200000 hands in all frames together, which are the most possible";
    if (isNew)
    {
        _frames.emplace_back();
        _frames.back().time_s = row.time_s;
    }
    if (!hand)
    {
        hand = &_frames.back().hands.emplace_back();
        hand->id = row.hand;
        ++hands;
    }
    hand->joints[static_cast<std::size_t>(row.joint)] = row.value;
    return {};
}

double RecordedHandSource::duration_s() const
{
    return _frames.back().time_s;
}

bool RecordedHandSource::frameAt(double time_s, HandFrame& frame)
{
    const double t = recordedTime(time_s, duration_s(), _loop);
    const auto after =
        std::lower_bound(_frames.begin(),
                         _frames.end(),
                         t,
                         [](const HandFrame& f, double value) { return f.time_s < value; });
    if (after != _frames.end() && after->time_s == t)
        frame = *after;
    else if (after == _frames.begin() || after == _frames.end())
        frame.hands.clear();
    else
    {
        const HandFrame& before = *(after - 1);
        const double gap = after->time_s - before.time_s;
        if (gap > kLongestGap_s)
            frame.hands.clear();
        else
            frame = between(before, *after, (t - before.time_s) / gap);
    }
    frame.time_s = time_s;
    return !frame.hands.empty();
}

std::string RecordedHandSource::status() const
{
    return fmt::format("{}: {} recorded frames", _name, _frames.size());
}

void InjectedHandSource::set(const HandFrame& frame)
{
    const base::Lock lock(_mutex);
    _frame = frame;
    ++_set;
}

void InjectedHandSource::clear()
{
    const base::Lock lock(_mutex);
    _frame.hands.clear();
}

bool InjectedHandSource::frameAt(double time_s, HandFrame& frame)
{
    const base::Lock lock(_mutex);
    frame.time_s = time_s;
    frame.hands.clear();
    if (_frame.hands.empty() || !(std::abs(time_s - _frame.time_s) <= _staleAfter_s)) return false;
    frame = _frame;
    return true;
}

std::string InjectedHandSource::status() const
{
    const base::Lock lock(_mutex);
    return fmt::format("hands set by the application, {} frames so far", _set);
}

} // namespace midair::bridge
