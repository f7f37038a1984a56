#include "engine-bridge/hands/Hand.h"

#include <algorithm>
#include <cassert>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr std::array<const char*, HAND_JOINTS> kJointNames = {"palm",
                                                              "wrist",
                                                              "thumb metacarpal",
                                                              "thumb proximal",
                                                              "thumb distal",
                                                              "thumb tip",
                                                              "index metacarpal",
                                                              "index proximal",
                                                              "index intermediate",
                                                              "index distal",
                                                              "index tip",
                                                              "middle metacarpal",
                                                              "middle proximal",
                                                              "middle intermediate",
                                                              "middle distal",
                                                              "middle tip",
                                                              "ring metacarpal",
                                                              "ring proximal",
                                                              "ring intermediate",
                                                              "ring distal",
                                                              "ring tip",
                                                              "little metacarpal",
                                                              "little proximal",
                                                              "little intermediate",
                                                              "little distal",
                                                              "little tip"};

/// The two joints of a bone.
struct Bone
{
    int from;
    int to;
};

std::array<Bone, kHandBones> makeBones()
{
    std::array<Bone, kHandBones> bones{};
    std::size_t next = 0;
    for (const int root : {THUMB_METACARPAL,
                           INDEX_METACARPAL,
                           MIDDLE_METACARPAL,
                           RING_METACARPAL,
                           LITTLE_METACARPAL})
    {
        bones[next++] = {WRIST, root};
        const int tip = root == THUMB_METACARPAL ? THUMB_TIP : root + 4;
        for (int joint = root; joint < tip; ++joint)
            bones[next++] = {joint, joint + 1};
    }
    return bones;
}

const std::array<Bone, kHandBones>& bones()
{
    static const std::array<Bone, kHandBones> all = makeBones();
    return all;
}

/// x and z of a right hand's joint in the palm frame (y = 0) and its radius, in mm: rounded values
/// of an adult's hand.
struct FlatJoint
{
    double x;
    double z;
    double radius;
};

constexpr std::array<FlatJoint, HAND_JOINTS> kFlatHand = {
    {{0, 0, 14},    {0, 70, 20},    {-25, 50, 15}, {-45, 20, 12}, {-60, -10, 10}, {-70, -33, 8},
     {-18, 45, 14}, {-25, -30, 11}, {-28, -72, 9}, {-30, -96, 8}, {-31, -114, 7}, {-3, 43, 14},
     {-4, -33, 11}, {-4, -80, 9},   {-4, -107, 8}, {-4, -126, 7}, {11, 45, 13},   {15, -28, 10},
     {18, -71, 9},  {19, -97, 8},   {20, -115, 7}, {22, 48, 12},  {32, -20, 9},   {38, -53, 8},
     {41, -72, 7},  {43, -89, 6}}};

} // namespace

HandFinger fingerOf(int bone)
{
    assert(bone >= 0 && bone < kHandBones);
    const Bone& which = bones()[static_cast<std::size_t>(bone)];
    if (which.from == WRIST) return PALM_OF_HAND;
    if (which.to <= THUMB_TIP) return THUMB;
    const int along = which.to - INDEX_METACARPAL; // five joints a finger
    return along % 5 == 1 ? PALM_OF_HAND : static_cast<HandFinger>(INDEX + along / 5);
}

std::string boneName(int bone)
{
    assert(bone >= 0 && bone < kHandBones);
    const Bone& which = bones()[static_cast<std::size_t>(bone)];
    return std::string(jointName(which.from)) + " to " + jointName(which.to);
}

const char* jointName(int joint)
{
    assert(joint >= 0 && joint < HAND_JOINTS);
    return kJointNames[static_cast<std::size_t>(joint)];
}

// NaN is left out by handCapsules(): a tracker may use it for unknown positions.
std::string leaveOutImpossible(Hand& hand)
{
    std::string wrong;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
    {
        HandJoint& joint = hand.joints[i];
        const double away_m = joint.position.norm();
        const bool isFar = away_m > kFarthestJoint_m;
        if (!joint.positionValid || !(isFar || joint.radius_m > kThickestJoint_m)) continue;
        joint.positionValid = false;
        if (!wrong.empty()) continue;
        wrong =
            fmt::format("the {} of hand {} is left out: ", jointName(static_cast<int>(i)), hand.id);
        wrong += isFar ? fmt::format(
                             "it is {:g} m away, should be within {:g} m", away_m, kFarthestJoint_m)
                       : fmt::format("its radius is {:g} m, should be up to {:g} m",
                                     joint.radius_m,
                                     kThickestJoint_m);
    }
    return wrong;
}

std::vector<HandCapsule> handCapsules(const HandFrame& frame)
{
    const auto usable = [](const HandJoint& joint)
    { return joint.positionValid && joint.position.allFinite() && joint.radius_m > 0.0; };
    std::vector<HandCapsule> capsules;
    capsules.reserve(frame.hands.size() * kHandBones);
    for (const Hand& hand : frame.hands)
        for (int bone = 0; bone < kHandBones; ++bone)
        {
            const Bone& which = bones()[static_cast<std::size_t>(bone)];
            const HandJoint& from = hand.joints[static_cast<std::size_t>(which.from)];
            const HandJoint& to = hand.joints[static_cast<std::size_t>(which.to)];
            if (!usable(from) || !usable(to)) continue;
            const Capsule shape = {from.position, to.position, 0.5 * (from.radius_m + to.radius_m)};
            capsules.push_back({shape, hand.id, bone, std::max(from.sigma_m, to.sigma_m)});
        }
    return capsules;
}

HandFrame transformed(const HandFrame& frame, const Eigen::Isometry3d& motion)
{
    HandFrame result = frame;
    const Eigen::Quaterniond turn(motion.linear());
    for (Hand& hand : result.hands)
        for (HandJoint& joint : hand.joints)
        {
            joint.position = motion * joint.position;
            joint.orientation = turn * joint.orientation;
        }
    for (HandPress& press : result.presses)
        press.place = motion * press.place;
    return result;
}

Hand openHand(int id, const Eigen::Isometry3d& palm)
{
    Hand hand;
    hand.id = id;
    const double side = id == 0 ? -1.0 : 1.0;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
    {
        const FlatJoint& flat = kFlatHand[i];
        HandJoint& joint = hand.joints[i];
        joint.position = palm * Eigen::Vector3d(side * 1e-3 * flat.x, 0.0, 1e-3 * flat.z);
        joint.orientation = Eigen::Quaterniond(palm.linear());
        joint.radius_m = 1e-3 * flat.radius;
        joint.positionValid = true;
        joint.orientationValid = true;
    }
    return hand;
}

Hand openHandWithIndexTipAt(int id,
                            const Eigen::Vector3d& tip,
                            const Eigen::Quaterniond& orientation)
{
    Eigen::Isometry3d palm = Eigen::Isometry3d::Identity();
    palm.linear() = orientation.toRotationMatrix();
    palm.translation() = tip - openHand(id, palm).joints[INDEX_TIP].position;
    return openHand(id, palm);
}

} // namespace midair::bridge
