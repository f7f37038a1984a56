#include "engine-bridge/hands/osc/OscInbox.h"

#include "haptics/base/InputError.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::bridge
{

void OscInbox::take(const char* data, std::size_t size, const std::string& sender, double now_s)
{
    OscContent content;
    std::string wrong;
    try
    {
        content = decodeOsc(data, size);
    }
    catch (const base::InputError& error)
    {
        wrong = error.what();
    }
    const base::Lock lock(_mutex);
    ++_counts.datagrams;
    if (!wrong.empty())
    {
        ++_counts.malformed;
        tellOnce("malformed",
                 "an invalid datagram is ignored, and so will be the next ones: " + wrong);
        return;
    }
    for (const OscContent::Timed& timed : content.hands)
        if (take(_sides[static_cast<std::size_t>(timed.hand.id)],
                 {timed.hand, timed.time_s, now_s, sender},
                 timed.hand.id == 0 ? "left hand" : "right hand"))
            ++_counts.hands;
    if (content.head && take(_head, {*content.head, content.head->time_s, now_s, sender}, "head"))
        ++_counts.heads;
    for (const std::string& text : content.texts)
        _messages.say({base::MessageCode::HANDS_SOURCE, text});
    _counts.unknown += content.unknownCount;
    if (!content.unknown.empty())
        tellOnce("unknown",
                 "messages to " + content.unknown + " are ignored; hands come to " + kOscHand +
                     ", a head to " + kOscHead);
    _counts.jointsLeftOut += content.jointsLeftOut;
    if (!content.firstLeftOut.empty())
        tellOnce("left out",
                 content.firstLeftOut + " is left out, and so will be the next ones; valid are "
                                        "positions within 1000 m and radii over 0, up to 0.1 m");
}

// A sender that was lost may start again with another clock, or be another sender.
template<typename T>
bool OscInbox::take(Newest<T>& newest, const Newest<T>& next, const std::string& name)
{
    if (!newest.isLost(next.arrived_s))
    {
        if (newest.sender != next.sender)
        {
            ++_counts.ofOthers;
            tellOnce("of others",
                     fmt::format("two senders have a {}: the first one's is taken", name));
            return false;
        }
        if (next.time_s <= newest.time_s) // also false without a time
        {
            ++_counts.late;
            tellOnce("late",
                     fmt::format("a {} is ignored, as its time {:.6f} s isn't after {:.6f} s, "
                                 "that of the one before",
                                 name,
                                 next.time_s,
                                 newest.time_s));
            return false;
        }
    }
    newest = next;
    return true;
}

bool OscInbox::mayBeOf(const std::string& sender, double now_s) const
{
    const base::Lock lock(_mutex);
    const auto mayGive = [&](const auto& newest)
    { return newest.sender == sender || newest.isLost(now_s); };
    return std::any_of(_sides.begin(), _sides.end(), mayGive) || (_isHeadAsked && mayGive(_head));
}

void OscInbox::passOver()
{
    const base::Lock lock(_mutex);
    ++_counts.datagrams;
    ++_counts.ofOthers;
    tellOnce("of others", "another sender is ignored, as the first one has both hands");
}

bool OscInbox::latest(double now_s, HandFrame& frame) const
{
    const base::Lock lock(_mutex);
    frame.hands.clear();
    for (const Newest<Hand>& side : _sides)
    {
        const bool isSeen = std::any_of(side.what.joints.begin(),
                                        side.what.joints.end(),
                                        [](const HandJoint& joint) { return joint.positionValid; });
        if (!isSeen || side.isLost(now_s)) continue;
        frame.hands.push_back(side.what);
        frame.hands.back().age_s += std::max(0.0, now_s - side.arrived_s);
    }
    return !frame.hands.empty();
}

bool OscInbox::latestHead(double now_s, Head& head) const
{
    const base::Lock lock(_mutex);
    _isHeadAsked = true;
    head = _head.what;
    head.isTracked = head.isTracked && !_head.isLost(now_s);
    head.age_s += std::max(0.0, now_s - _head.arrived_s);
    return head.isTracked;
}

void OscInbox::tellOnce(const char* what, const std::string& message)
{
    if (_messages.begins({base::MessageCode::HANDS_SOURCE, 0, what})) say(message);
}

void OscInbox::say(const std::string& message)
{
    _messages.say({base::MessageCode::HANDS_SOURCE, _name + ": " + message});
}

std::vector<std::string> OscInbox::messages(std::size_t& told) const
{
    return _messages.newTexts(told);
}

OscCounts OscInbox::counts() const
{
    const base::Lock lock(_mutex);
    return _counts;
}

std::string OscInbox::status() const
{
    const OscCounts counts = this->counts();
    std::string text = fmt::format("{}: {} hands", _name, counts.hands);
    if (counts.heads > 0) text += fmt::format(", {} heads", counts.heads);
    std::string ignored;
    const auto add = [&](std::uint64_t count, const char* what)
    {
        if (count > 0) ignored += fmt::format("{}{} {}", ignored.empty() ? "" : ", ", count, what);
    };
    add(counts.malformed, "invalid datagrams");
    add(counts.late, "out of order");
    add(counts.ofOthers, "of another sender");
    add(counts.unknown, "to another address");
    add(counts.jointsLeftOut, "impossible joints or heads");
    return ignored.empty() ? text : text + "; ignored: " + ignored;
}

} // namespace midair::bridge
