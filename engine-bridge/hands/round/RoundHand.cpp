#include "engine-bridge/hands/round/RoundHand.h"

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Geometry>

namespace midair::bridge
{

namespace
{

haptics::RoundCone coneOf(const Hand& hand, int from, int to)
{
    const HandJoint &a = hand.joints[static_cast<std::size_t>(from)],
                    &b = hand.joints[static_cast<std::size_t>(to)];
    return {a.position, b.position, a.radius_m, b.radius_m};
}

} // namespace

RoundHand roundHand()
{
    const Hand hand = openHand(1, Eigen::Isometry3d::Identity());
    RoundHand round;
    for (const int root : {THUMB_METACARPAL,
                           INDEX_METACARPAL,
                           MIDDLE_METACARPAL,
                           RING_METACARPAL,
                           LITTLE_METACARPAL})
    {
        round.cones.push_back(coneOf(hand, PALM, root));
        const int tip = root == THUMB_METACARPAL ? THUMB_TIP : root + 4;
        for (int joint = root; joint < tip; ++joint)
            round.cones.push_back(coneOf(hand, joint, joint + 1));
    }
    for (const int knuckle : {INDEX_PROXIMAL, MIDDLE_PROXIMAL, RING_PROXIMAL})
    {
        round.cones.push_back(coneOf(hand, knuckle, knuckle + 5));
        round.cones.push_back(coneOf(hand, PALM, knuckle));
    }
    round.cones.push_back(coneOf(hand, PALM, LITTLE_PROXIMAL));
    round.indexTip = hand.joints[INDEX_TIP].position;
    round.indexRadius_m = hand.joints[INDEX_TIP].radius_m;
    return round;
}

} // namespace midair::bridge
