#include "engine-bridge/hands/prediction/HandPredictor.h"

#include "haptics/base/SmallMatrices.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

// Effects of a tracker's noise of 1 mm per joint. The gains don't depend on these numbers, only the
// expected errors do.
constexpr double kPlaceNoise_m = 1e-3;
constexpr double kTurnNoise = 0.01;   ///< rad, for a palm about 80 mm wide
constexpr double kFingerNoise = 0.02; ///< rad, for a finger of about 70 mm

// Lever of a rotation: from the palm to the fingertips, and from the knuckle to the tip.
constexpr double kPalmLever_m = 0.1;
constexpr double kFingerLever_m = 0.07;

/// Least width of a shape, and length of a finger, for measuring its rotation.
constexpr double kLeastWidth_m = 0.02;
constexpr double kLeastFinger_m = 0.005;

/// A finger's joints: those from knuckle + 1 to tip rotate around the knuckle.
struct FingerJoints
{
    int knuckle;
    int tip;
};

constexpr FingerJoints kFingerJoints[] = {{THUMB_METACARPAL, THUMB_TIP},
                                          {INDEX_PROXIMAL, INDEX_TIP},
                                          {MIDDLE_PROXIMAL, MIDDLE_TIP},
                                          {RING_PROXIMAL, RING_TIP},
                                          {LITTLE_PROXIMAL, LITTLE_TIP}};

/// The joints that bend least against each other. The thumb's metacarpal doesn't belong to them.
constexpr int kPalmJoints[] = {PALM,
                               WRIST,
                               INDEX_METACARPAL,
                               INDEX_PROXIMAL,
                               MIDDLE_METACARPAL,
                               MIDDLE_PROXIMAL,
                               RING_METACARPAL,
                               RING_PROXIMAL,
                               LITTLE_METACARPAL,
                               LITTLE_PROXIMAL};

const HandJoint& jointOf(const Hand& hand, int joint)
{
    return hand.joints[static_cast<std::size_t>(joint)];
}

/// Rotation by the vector \a turn: axis times angle.
Eigen::Quaterniond turnBy(const Eigen::Vector3d& turn)
{
    const double angle = turn.norm();
    if (!(angle > 0.0)) return Eigen::Quaterniond::Identity();
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

Eigen::Vector3d vectorOf(const Eigen::Quaterniond& turn)
{
    const Eigen::AngleAxisd both(turn); // its angle is in 0 .. pi
    return both.angle() * both.axis();
}

/// Rotates a joint by \a turn around \a centre. \a sigma: of the rotation, rad.
void turnAbout(const Eigen::Vector3d& centre,
               const Eigen::Quaterniond& turn,
               double sigma,
               HandJoint& joint)
{
    const Eigen::Vector3d lever = joint.position - centre;
    joint.sigma_m = std::hypot(joint.sigma_m, sigma * lever.norm());
    if (turn.vec().isZero(0.0)) return; // keeps resting joints exact to the last bit
    joint.position = centre + turn * lever;
    if (joint.orientationValid) joint.orientation = (turn * joint.orientation).normalized();
}

/// Sources may use any hand numbers; problems beyond this many hands are reported as those of one.
constexpr std::size_t kMostTold = 16;
constexpr int kOthers = -1;

std::string nameOf(const Hand& hand)
{
    if (hand.id == 0) return "the left hand";
    if (hand.id == 1) return "the right hand";
    if (hand.id == HandPredictor::kHead) return "the head";
    return fmt::format("hand {}", hand.id);
}

/// First joint marked as valid with a position that isn't finite; -1: none.
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

bool HandMotion::isLast(const Hand& hand) const
{
    return std::equal(hand.joints.begin(),
                      hand.joints.end(),
                      _last.joints.begin(),
                      [](const HandJoint& a, const HandJoint& b)
                      { return a.positionValid == b.positionValid && a.position == b.position; });
}

HandMotion::Joints HandMotion::rigidJoints(const Hand& hand)
{
    Joints palm;
    for (const int joint : kPalmJoints)
        palm.set(static_cast<std::size_t>(joint), jointOf(hand, joint).positionValid);
    if (palm.any()) return palm;
    Joints all;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
        all.set(i, hand.joints[i].positionValid);
    return all;
}

Eigen::Vector3d HandMotion::middle(const Hand& hand) const
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
        if (_rigid[i]) sum += hand.joints[i].position;
    return sum / static_cast<double>(_rigid.count());
}

// The rigid joints relative to their middle.
Eigen::Matrix3Xd HandMotion::shapeOf(const Hand& hand) const
{
    Eigen::Matrix3Xd shape(3, static_cast<Eigen::Index>(_rigid.count()));
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
        if (_rigid[i]) shape.col(column++) = hand.joints[i].position;
    return shape.colwise() - middle(hand);
}

Eigen::Quaterniond HandMotion::fittedTurn(const Hand& hand) const
{
    const Eigen::Matrix4d motion = base::nearestMotion(_shape, shapeOf(hand), false);
    return Eigen::Quaterniond(Eigen::Matrix3d(motion.topLeftCorner<3, 3>()));
}

void HandMotion::begin(double time_s, const Hand& hand)
{
    if (!_place) _place = std::make_unique<MotionTrack>(_method, kPlaceNoise_m, 1.0);
    const Eigen::Vector3d centre = _rigid.any() ? middle(hand) : Eigen::Vector3d::Zero();
    _place->restart(time_s, centre);
    _shape = shapeOf(hand);
    // The second singular value measures the distance of the shape from a line.
    const bool isWide =
        _rigid.count() >= 3 &&
        base::singularParts(_shape * _shape.transpose()).values[1] > kLeastWidth_m * kLeastWidth_m;
    _turned.setIdentity();
    _turn = isWide ? std::make_unique<MotionTrack>(_method, kTurnNoise, kPalmLever_m) : nullptr;
    if (_turn) _turn->restart(time_s, Eigen::Vector3d::Zero());
    for (Finger& finger : _fingers)
        finger.turn.reset();
    followFingers(time_s);
}

HandMotion::Outcome HandMotion::update(double time_s, const Hand& hand, double& jump_m)
{
    const double interval_s = time_s - _time_s;
    const Joints rigid = rigidJoints(hand);
    const bool goesOn =
        _place && rigid.any() && rigid == _rigid && interval_s > 0.0 && interval_s <= kLongestGap_s;
    _last = hand;
    _time_s = time_s;
    _rigid = rigid;
    const Eigen::Vector3d centre = goesOn ? middle(hand) : Eigen::Vector3d::Zero();
    jump_m = goesOn ? (centre - _place->place()).norm() : 0.0;
    const bool jumped = jump_m > std::max(kNearest_m, kFastest_mps * interval_s);
    if (!goesOn || jumped)
    {
        begin(time_s, hand);
        return jumped ? JUMPED : BEGUN;
    }
    _place->update(time_s, centre);
    if (_turn)
    {
        const Eigen::Quaterniond turned = fittedTurn(hand);
        _turn->update(time_s, _turn->place() + vectorOf(turned * _turned.conjugate()));
        _turned = turned;
    }
    followFingers(time_s);
    return FOLLOWED;
}

void HandMotion::followFingers(double time_s)
{
    for (int which = 0; which < kFingers && _turn; ++which)
        followFinger(which, time_s);
}

void HandMotion::followFinger(int which, double time_s)
{
    const FingerJoints& joints = kFingerJoints[which];
    Finger& finger = _fingers[static_cast<std::size_t>(which)];
    Joints tracked;
    int last = joints.knuckle;
    for (int joint = joints.knuckle; joint <= joints.tip; ++joint)
        if (jointOf(_last, joint).positionValid)
        {
            tracked.set(static_cast<std::size_t>(joint));
            last = joint;
        }
    const Eigen::Vector3d way =
        jointOf(_last, last).position - jointOf(_last, joints.knuckle).position;
    const double length = way.norm();
    if (!tracked[static_cast<std::size_t>(joints.knuckle)] || !(length > kLeastFinger_m))
    {
        finger.turn.reset();
        return;
    }
    const Eigen::Vector3d direction = _turned.conjugate() * (way / length);
    if (finger.turn && finger.tracked == tracked)
        finger.turn->update(time_s,
                            finger.turn->place() +
                                vectorOf(base::turnBetween(finger.direction, direction)));
    else
    {
        finger.turn = std::make_unique<MotionTrack>(_method, kFingerNoise, kFingerLever_m);
        finger.turn->restart(time_s, Eigen::Vector3d::Zero());
        finger.tracked = tracked;
    }
    finger.direction = direction;
}

// Predicts the finger on the palm as seen.
void HandMotion::turnFinger(int which, double ahead_s, Hand& hand) const
{
    const Finger& finger = _fingers[static_cast<std::size_t>(which)];
    if (!finger.turn) return;
    const FingerJoints& joints = kFingerJoints[which];
    const PredictedShift turn = finger.turn->predict(ahead_s);
    const Eigen::Quaterniond by = turnBy(_turned * turn.shift);
    const Eigen::Vector3d knuckle = jointOf(_last, joints.knuckle).position;
    for (int joint = joints.knuckle + 1; joint <= joints.tip; ++joint)
        turnAbout(knuckle, by, turn.sigma, hand.joints[static_cast<std::size_t>(joint)]);
}

Hand HandMotion::predict(double ahead_s) const
{
    Hand hand = _last;
    if (!_rigid.any()) return hand;
    for (HandJoint& joint : hand.joints)
        joint.sigma_m = 0.0;
    for (int which = 0; which < kFingers; ++which)
        turnFinger(which, ahead_s, hand);
    const PredictedShift way = _place->predict(ahead_s);
    const PredictedShift turn = _turn ? _turn->predict(ahead_s) : PredictedShift();
    const Eigen::Quaterniond by = turnBy(turn.shift);
    for (HandJoint& joint : hand.joints)
    {
        if (!joint.positionValid) continue;
        turnAbout(_place->place(), by, turn.sigma, joint);
        joint.position += way.shift;
        joint.sigma_m = std::hypot(joint.sigma_m, way.sigma);
    }
    return hand;
}

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

// Returns false if the hand is unchanged and its known motion is useless.
bool HandPredictor::predictHand(double time_s, double horizon_s, Hand& hand)
{
    if (!isUsable(hand, horizon_s)) return false;
    if (horizon_s + hand.age_s > kFarthest_s)
        say(hand.id,
            FAR_HORIZON,
            fmt::format("{} needs a prediction of {:.0f} ms, more than the limit of {:.0f} ms: it "
                        "is felt late",
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
            fmt::format("the {} of {} is marked as tracked, but its position is not finite: the "
                        "hand is not predicted until it is",
                        jointName(wrong),
                        nameOf(hand)));
    // Also false for NaN. An age below 0 belongs to a future time.
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
                fmt::format("{} jumped by {:.2f} m between two measurements: its prediction starts "
                            "again from there",
                            nameOf(hand),
                            jump_m));
    }
    const double ahead_s = std::min(target_s - motion.time_s(), kFarthest_s);
    // Without motion for this long, the hand is at rest, or the tracker is.
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

// A hand that comes back after a longer gap starts again without its old data.
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
