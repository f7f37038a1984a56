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
        tellOnce("malformed", "a datagram is ignored, as others like it will be: " + wrong);
        return;
    }
    for (const OscContent::Timed& timed : content.hands)
        takeHand(timed, sender, now_s);
    for (const std::string& text : content.texts)
        _messages.say({base::MessageCode::HANDS_SOURCE, text});
    _counts.unknown += content.unknownCount;
    if (!content.unknown.empty())
        tellOnce("unknown",
                 "messages to " + content.unknown + " are ignored; hands come to " + kOscHand);
    _counts.jointsLeftOut += content.jointsLeftOut;
    if (!content.firstLeftOut.empty())
        tellOnce(
            "left out",
            content.firstLeftOut +
                " is left out, as others will be; positions within 1000 m and radii over 0, up "
                "to 0.1 m are believed");
}

void OscInbox::takeHand(const OscContent::Timed& timed, const std::string& sender, double now_s)
{
    Side& side = _sides[static_cast<std::size_t>(timed.hand.id)];
    const char* which = timed.hand.id == 0 ? "left" : "right";
    // A sender that was lost may begin anew, with another clock, or be another one.
    if (now_s - side.arrived_s < kLost_s)
    {
        if (side.sender != sender)
        {
            ++_counts.ofOthers;
            tellOnce("of others",
                     fmt::format("two senders have a {} hand: the first one's is taken", which));
            return;
        }
        if (!(timed.time_s > side.time_s))
        {
            ++_counts.late;
            tellOnce("late",
                     fmt::format("a {} hand is ignored, as its time {:.6f} s isn't after {:.6f} s, "
                                 "that of the one before",
                                 which,
                                 timed.time_s,
                                 side.time_s));
            return;
        }
    }
    ++_counts.hands;
    side = {timed.hand, timed.time_s, now_s, sender};
}

bool OscInbox::mayBeOf(const std::string& sender, double now_s) const
{
    const base::Lock lock(_mutex);
    return std::any_of(_sides.begin(),
                       _sides.end(),
                       [&](const Side& side)
                       { return side.sender == sender || !(now_s - side.arrived_s < kLost_s); });
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
    for (const Side& side : _sides)
    {
        const bool isSeen = std::any_of(side.hand.joints.begin(),
                                        side.hand.joints.end(),
                                        [](const HandJoint& joint) { return joint.positionValid; });
        if (!isSeen || !(now_s - side.arrived_s < kLost_s)) continue;
        frame.hands.push_back(side.hand);
        frame.hands.back().age_s += std::max(0.0, now_s - side.arrived_s);
    }
    return !frame.hands.empty();
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
    std::string ignored;
    const auto add = [&](std::uint64_t count, const char* what)
    {
        if (count > 0) ignored += fmt::format("{}{} {}", ignored.empty() ? "" : ", ", count, what);
    };
    add(counts.malformed, "datagrams not understood");
    add(counts.late, "hands out of order");
    add(counts.ofOthers, "of another sender");
    add(counts.unknown, "to another address");
    add(counts.jointsLeftOut, "impossible joints");
    return ignored.empty() ? text : text + "; ignored: " + ignored;
}

} // namespace midair::bridge
