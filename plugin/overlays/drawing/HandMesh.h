#pragma once

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace osgMidair
{

/// \{ A finger moves by six frames: the half bend of each of its three joints, and the bone after
/// it. Frame 0 is the palm's; frame 1 + 6 * finger + 2 * k is that of joint k, the next one that of
/// bone k. Fingers are HandFinger's THUMB .. LITTLE.
constexpr int kHandChains = 5;
constexpr int kChainBones = 3;
constexpr int kHandFrames = 1 + 2 * kHandChains * kChainBones;
constexpr int jointFrame(int finger, int k)
{
    return 1 + 2 * (kChainBones * finger + k);
}
/// \}

/// Returns joint k (0 .. 3) of \a finger's chain, of midair::bridge::HandJointName: from the
/// knuckle, for the thumb from its metacarpal, to the tip.
int chainJoint(int finger, int k);

/// Returns the angle of \a finger towards the thumb at rest, from bridge::openHand().
double spreadAtRest_deg(int finger);

/// The skin of a right hand at rest: a closed, smooth surface of triangles around the bones of
/// bridge::openHand() with its fingers spread, with a piece of the forearm. Palm frame, metres.
struct HandMesh
{
    static constexpr int kInfluences = 4;
    struct Skin
    {
        std::array<unsigned char, kInfluences> frames{}; ///< frames that move a vertex
        std::array<float, kInfluences> shares{};         ///< their sum is 1; the largest first
        unsigned char count = 0;
        unsigned char bone = 0; ///< the nearest one, 0 .. bridge::kHandBones - 1
    };

    std::array<Eigen::Vector3d, midair::bridge::HAND_JOINTS> joints;
    std::array<double, midair::bridge::HAND_JOINTS> radii_m{};
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3f> normals; ///< unit, outwards
    std::vector<Skin> skin;               ///< of each vertex
    std::vector<unsigned int> triangles;  ///< three corners each, counterclockwise from outside
};

/// Returns the hand's skin; the first call makes it, in about ten milliseconds. From any thread.
const HandMesh& handMesh();

} // namespace osgMidair
