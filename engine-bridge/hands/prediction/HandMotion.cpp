#include "engine-bridge/hands/prediction/HandMotion.h"

#include "haptics/base/SmallMatrices.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

// What a tracker's noise of 1 mm a joint comes to. The gains don't depend on these figures, only
// the expected errors do.
constexpr double kPlaceNoise_m = 1e-3;
constexpr double kTurnNoise = 0.01;   ///< rad, of a palm some 80 mm wide
constexpr double kFingerNoise = 0.02; ///< rad, of a finger of some 70 mm

// What a turn moves: the fingertips of a turning palm, the tip of a turning finger.
constexpr double kPalmLever_m = 0.1;
constexpr double kFingerLever_m = 0.07;

/// A shape must be this wide for its turns to be seen, and a finger this long.
constexpr double kLeastWidth_m = 0.02;
constexpr double kLeastFinger_m = 0.005;

/// A finger's joints: those from knuckle + 1 to tip turn about the knuckle.
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

/// The joints that bend least against each other. The thumb's metacarpal isn't one.
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

/// The turn by the vector \a turn: axis times angle.
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

/// Turns a joint by \a turn about \a centre. \a sigma: of the turn, rad.
void turnAbout(const Eigen::Vector3d& centre,
               const Eigen::Quaterniond& turn,
               double sigma,
               HandJoint& joint)
{
    const Eigen::Vector3d lever = joint.position - centre;
    joint.sigma_m = std::hypot(joint.sigma_m, sigma * lever.norm());
    if (turn.vec().isZero(0.0)) return; // so that what rests stays to the last bit
    joint.position = centre + turn * lever;
    if (joint.orientationValid) joint.orientation = (turn * joint.orientation).normalized();
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

// W. Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta Cryst. A 32,
// 1976. _shape is centred.
Eigen::Quaterniond HandMotion::fittedTurn(const Hand& hand) const
{
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    const Eigen::Vector3d centre = middle(hand);
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
        if (_rigid[i])
            products += (hand.joints[i].position - centre) * _shape.col(column++).transpose();
    const base::SingularParts svd = base::singularParts(products);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    signs.z() = (svd.U * svd.V.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    const Eigen::Matrix3d turn = svd.U * signs.asDiagonal() * svd.V.transpose();
    return Eigen::Quaterniond(turn);
}

void HandMotion::begin(double time_s, const Hand& hand)
{
    if (!_place) _place = std::make_unique<MotionTrack>(_method, kPlaceNoise_m, 1.0);
    const Eigen::Vector3d centre = _rigid.any() ? middle(hand) : Eigen::Vector3d::Zero();
    _place->restart(time_s, centre);
    _shape.resize(3, static_cast<Eigen::Index>(_rigid.count()));
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
        if (_rigid[i]) _shape.col(column++) = hand.joints[i].position - centre;
    // The second singular value says how far the shape is from a line.
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

// The finger as it will be on the palm as it was seen.
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

} // namespace midair::bridge
