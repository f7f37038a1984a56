#pragma once

#include <Eigen/Geometry>

#include <array>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The joints of a hand, in the order of OpenXR's XR_EXT_hand_tracking.
enum HandJointName
{
    PALM,
    WRIST,
    THUMB_METACARPAL,
    THUMB_PROXIMAL,
    THUMB_DISTAL,
    THUMB_TIP,
    INDEX_METACARPAL,
    INDEX_PROXIMAL,
    INDEX_INTERMEDIATE,
    INDEX_DISTAL,
    INDEX_TIP,
    MIDDLE_METACARPAL,
    MIDDLE_PROXIMAL,
    MIDDLE_INTERMEDIATE,
    MIDDLE_DISTAL,
    MIDDLE_TIP,
    RING_METACARPAL,
    RING_PROXIMAL,
    RING_INTERMEDIATE,
    RING_DISTAL,
    RING_TIP,
    LITTLE_METACARPAL,
    LITTLE_PROXIMAL,
    LITTLE_INTERMEDIATE,
    LITTLE_DISTAL,
    LITTLE_TIP,
    HAND_JOINTS
};

/// One tracked joint. Position and orientation are known independently.
struct HandJoint
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero();              ///< metres
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity(); ///< unit
    double radius_m = 0.0;                                           ///< distance to the skin
    bool positionValid = false;
    bool orientationValid = false;
    /// m; expected error of a predicted position; 0: as measured
    double sigma_m = 0.0;
};

/// \{ Limits for sources: a joint beyond them is invalid.
constexpr double kThickestJoint_m = 0.1;
constexpr double kFarthestJoint_m = 1000.0; ///< from the origin of its frame
/// \}

/// One tracked hand.
struct Hand
{
    int id = 0; ///< constant from frame to frame; 0 left, 1 right
    std::array<HandJoint, HAND_JOINTS> joints;
    double age_s = 0.0; ///< >= 0; time before the frame at which the tracker saw it
};

/// A bone pushing a body of a simulated world.
struct HandPress
{
    int hand = 0;                                    ///< Hand::id
    int bone = 0;                                    ///< 0 .. kHandBones - 1
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< m, on the body
    double force_N = 0.0;                            ///< >= 0; mean since the last frame
};

/// The hands at one time, in one frame of reference.
struct HandFrame
{
    double time_s = 0.0;
    std::vector<Hand> hands;
    std::vector<HandPress> presses; ///< pushes of these hands, from HandBodies
};

/// All points within radius_m of the segment from a to b: a bone of a hand with its flesh, or a
/// prop.
struct Capsule
{
    Eigen::Vector3d a; ///< metres
    Eigen::Vector3d b; ///< metres
    double radius_m = 0.0;
};

/// Returns \a capsule moved by \a motion.
inline Capsule moved(const Capsule& capsule, const Eigen::Isometry3d& motion)
{
    return {motion * capsule.a, motion * capsule.b, capsule.radius_m};
}

/// The capsule of one bone of a hand.
struct HandCapsule
{
    Capsule shape;
    int hand = 0;         ///< Hand::id
    int bone = 0;         ///< 0 .. kHandBones - 1
    double sigma_m = 0.0; ///< the larger sigma_m of its joints
};

constexpr int kHandBones = 24; ///< per finger: wrist to metacarpal, then along the finger

/// Returns "index distal to index tip" and so on, for messages. \a bone in 0 .. kHandBones - 1.
std::string boneName(int bone);

/// Fingers of a hand, for touches; the palm consists of the bones at the wrist, and those from
/// metacarpal to proximal except the thumb's.
enum HandFinger
{
    THUMB,
    INDEX,
    MIDDLE,
    RING,
    LITTLE,
    PALM_OF_HAND,
    HAND_FINGERS
};

/// Returns the finger of \a bone (0 .. kHandBones - 1).
HandFinger fingerOf(int bone);

/// Returns "index tip" and so on; recordings have underscores instead of blanks.
const char* jointName(int joint);

/// Marks valid joints of \a hand that are farther than kFarthestJoint_m or thicker than
/// kThickestJoint_m as not tracked. Returns the problem of the first of them; empty: none.
std::string leaveOutImpossible(Hand& hand);

/// Returns a capsule for each bone whose two joints have a valid, finite position and a radius over
/// 0; its radius is their mean.
std::vector<HandCapsule> handCapsules(const HandFrame& frame);

/// Returns \a frame with all joints and presses moved by \a motion; radii stay.
HandFrame transformed(const HandFrame& frame, const Eigen::Isometry3d& motion);

/// Returns a flat open right (id 1) or left hand (id 0) of an adult, fingers along -z of \a palm,
/// the back of the hand towards +y (OpenXR's palm frame); about 190 mm from the wrist to the middle
/// finger's tip. Used for mice, tests and samples.
Hand openHand(int id, const Eigen::Isometry3d& palm);

/// The same, moved so that the index finger's tip (the centre of its last joint's sphere) is at \a
/// tip.
Hand openHandWithIndexTipAt(int id,
                            const Eigen::Vector3d& tip,
                            const Eigen::Quaterniond& orientation);

} // namespace midair::bridge
