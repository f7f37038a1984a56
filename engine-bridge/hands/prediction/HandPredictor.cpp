#include "engine-bridge/hands/prediction/HandPredictor.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Sources may number their hands as they like; the troubles of more than so many are told as those
/// of one.
constexpr std::size_t kMostTold = 16;
constexpr int kOthers = -1;

std::string nameOf(const Hand& hand)
{
    if (hand.id == 0) return "the left hand";
    if (hand.id == 1) return "the right hand";
    return fmt::format("hand {}", hand.id);
}

/// The first joint that is said to be valid and isn't; -1: none.
int wrongJoint(const Hand& hand)
{
    for (int i = 0; i < HAND_JOINTS; ++i)
    {
        const HandJoint& joint = hand.joints[static_cast<std::size_t>(i)];
        if (joint.positionValid && !joint.position.allFinite()) return i;
        if (joint.orientationValid && !joint.orientation.coeffs().allFinite()) return i;
    }
    return -1;
}

void setSigma(Hand& hand, double sigma_m)
{
    for (HandJoint& joint : hand.joints)
        joint.sigma_m = sigma_m;
}

} // namespace

void HandPredictor::setMethod(PredictionMethod method)
{
    if (method == _method) return;
    _method = method;
    _hands.clear();
    _told.clear();
    _ahead_s = 0.0;
}

void HandPredictor::predict(HandFrame& frame, double horizon_s)
{
    _ahead_s = 0.0;
    if (_method == PredictionMethod::OFF) return;
    std::vector<int> seen;
    for (Hand& hand : frame.hands)
    {
        setSigma(hand, MotionTrack::kUnknown * kFarthest_s);
        if (std::find(seen.begin(), seen.end(), hand.id) != seen.end())
        {
            say(hand.id,
                TWICE,
                "there are two of " + nameOf(hand) + " at one time: only the first is predicted");
            continue;
        }
        seen.push_back(hand.id);
        if (!predictHand(frame.time_s, horizon_s, hand)) _hands.erase(hand.id);
    }
    dropLost(frame.time_s, seen);
}

// Returns false if the hand is left as it is, and what was known of it is worth nothing.
bool HandPredictor::predictHand(double time_s, double horizon_s, Hand& hand)
{
    if (!isUsable(hand, horizon_s)) return false;
    if (horizon_s + hand.age_s > kFarthest_s)
        say(hand.id,
            FAR_HORIZON,
            fmt::format("{} would have to be predicted by {:.0f} ms, the most possible is {:.0f} "
                        "ms: it is felt late",
                        nameOf(hand),
                        1e3 * (horizon_s + hand.age_s),
                        1e3 * kFarthest_s));
    const double ahead_s = std::min(horizon_s + hand.age_s, kFarthest_s);
    if (_method == PredictionMethod::TRACKER)
    {
        const MotionNoise noise;
        setSigma(hand, std::hypot(noise.measured, 0.5 * noise.acceleration * ahead_s * ahead_s));
        _ahead_s = std::max(_ahead_s, ahead_s);
        return true;
    }
    move(time_s, time_s - hand.age_s + ahead_s, hand);
    return true;
}

bool HandPredictor::isUsable(const Hand& hand, double horizon_s)
{
    const int wrong = wrongJoint(hand);
    if (wrong >= 0)
        say(hand.id,
            NO_NUMBER,
            fmt::format("the {} of {} is said to be tracked and has no finite place: the hand is "
                        "not predicted as long as that lasts",
                        jointName(wrong),
                        nameOf(hand)));
    // False for NaN, too. An age under 0 is of a time that hasn't come.
    const bool isAhead = horizon_s >= 0.0 && hand.age_s >= 0.0 && std::isfinite(horizon_s) &&
                         std::isfinite(hand.age_s);
    if (!isAhead)
        say(hand.id,
            NO_HORIZON,
            fmt::format("{} can't be predicted by {:g} s from a measurement that is {:g} s old; "
                        "both should be 0 or more: it stays where it was seen",
                        nameOf(hand),
                        horizon_s,
                        hand.age_s));
    return wrong < 0 && isAhead;
}

void HandPredictor::move(double time_s, double target_s, Hand& hand)
{
    const auto [found, isNew] = _hands.try_emplace(hand.id, _method);
    HandMotion& motion = found->second;
    const double seen_s = time_s - hand.age_s;
    const bool goesBack = !isNew && time_s < motion.time_s();
    if (isNew || goesBack || !motion.isLast(hand))
    {
        double jump_m = 0.0;
        if (motion.update(seen_s, hand, jump_m) == HandMotion::JUMPED)
            say(hand.id,
                JUMP,
                fmt::format("{} has jumped by {:.2f} m from one measurement to the next: it is "
                            "predicted anew from there",
                            nameOf(hand),
                            jump_m));
    }
    const double ahead_s = std::min(target_s - motion.time_s(), kFarthest_s);
    // What hasn't moved for so long is at rest, or the tracker is.
    if (time_s - motion.time_s() > HandMotion::kLongestGap_s)
    {
        setSigma(hand, MotionNoise().measured);
        return;
    }
    const double age_s = hand.age_s;
    hand = motion.predict(std::max(ahead_s, 0.0));
    hand.age_s = age_s;
    _ahead_s = std::max(_ahead_s, ahead_s);
}

// A hand that comes back after a longer gap is begun anew, and needs nothing of what was.
void HandPredictor::dropLost(double time_s, const std::vector<int>& seen)
{
    for (auto hand = _hands.begin(); hand != _hands.end();)
    {
        const bool isSeen = std::find(seen.begin(), seen.end(), hand->first) != seen.end();
        const double since_s = std::abs(time_s - hand->second.time_s());
        const bool isLost = !isSeen && since_s > HandMotion::kLongestGap_s;
        hand = isLost ? _hands.erase(hand) : std::next(hand);
    }
}

void HandPredictor::say(int hand, Trouble trouble, const std::string& what)
{
    const bool isKnown = _told.count(hand) > 0 || _told.size() < kMostTold;
    unsigned& told = _told[isKnown ? hand : kOthers];
    if ((told & trouble) != 0) return;
    told |= trouble;
    _messages.push_back(what);
}

std::vector<std::string> HandPredictor::takeMessages()
{
    std::vector<std::string> messages;
    messages.swap(_messages);
    return messages;
}

} // namespace midair::bridge
