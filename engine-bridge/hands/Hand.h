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

/// One tracked joint. A tracker may know its position but not its orientation, or neither.
struct HandJoint
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero();              ///< metres
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity(); ///< unit
    double radius_m = 0.0;                                           ///< distance of the skin
    bool positionValid = false;
    bool orientationValid = false;
    /// m; expected error of a position that was predicted; 0: it is as it was measured
    double sigma_m = 0.0;
};

/// \{ Limits of what a source may say: beyond them a joint is none of a hand.
constexpr double kThickestJoint_m = 0.1;
constexpr double kFarthestJoint_m = 1000.0; ///< from the origin of the frame that it is in
/// \}

/// One tracked hand.
struct Hand
{
    int id = 0; ///< stays the same from frame to frame; 0 left, 1 right
    std::array<HandJoint, HAND_JOINTS> joints;
    double age_s = 0.0; ///< >= 0; how long before the frame's time the tracker saw it
};

/// A bone that pushes a body of a simulated world.
struct HandPress
{
    int hand = 0;                                    ///< Hand::id
    int bone = 0;                                    ///< 0 .. kHandBones - 1
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< m, on the body
    double force_N = 0.0;                            ///< >= 0; mean since the frame before
};

/// The hands at one time, in one frame of reference.
struct HandFrame
{
    double time_s = 0.0;
    std::vector<Hand> hands;
    std::vector<HandPress> presses; ///< what HandBodies knows of these hands
};

/// All points within radius_m of the segment from a to b: a bone of a hand with its flesh, or a
/// prop.
struct Capsule
{
    Eigen::Vector3d a; ///< metres
    Eigen::Vector3d b; ///< metres
    double radius_m = 0.0;
};

/// \a capsule, moved by \a motion.
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
    double sigma_m = 0.0; ///< the larger of its joints' sigma_m
};

constexpr int kHandBones = 24; ///< for each finger: wrist to metacarpal, then along the finger

/// "index distal to index tip" and the like, for messages. \a bone in 0 .. kHandBones - 1.
std::string boneName(int bone);

/// Fingers of a hand, for touches; the palm is what joins them: the bones at the wrist, and those
/// from metacarpal to proximal but for the thumb's.
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

/// The finger that \a bone (0 .. kHandBones - 1) belongs to.
HandFinger fingerOf(int bone);

/// "index tip" and the like; recordings have an underscore for each blank.
const char* jointName(int joint);

/// Marks the joints of \a hand that are valid by what they say, and farther than kFarthestJoint_m
/// or thicker than kThickestJoint_m, as not tracked. Returns what is wrong with the first of them;
/// empty: nothing.
std::string leaveOutImpossible(Hand& hand);

/// A capsule for each bone whose two joints have a valid, finite position and a radius over 0; its
/// radius is the mean of theirs.
std::vector<HandCapsule> handCapsules(const HandFrame& frame);

/// \a frame with all joints and presses moved by \a motion; radii stay.
HandFrame transformed(const HandFrame& frame, const Eigen::Isometry3d& motion);

/// A flat open right (id 1) or left hand (id 0) of an adult, fingers along -z of \a palm, the back
/// of the hand towards +y (OpenXR's palm frame); about 190 mm from the wrist to the middle finger's
/// tip. Used for mice, tests and samples.
Hand openHand(int id, const Eigen::Isometry3d& palm);

/// The same, moved so that the index finger's tip (the middle of its last joint's ball) is at \a
/// tip.
Hand openHandWithIndexTipAt(int id,
                            const Eigen::Vector3d& tip,
                            const Eigen::Quaterniond& orientation);

} // namespace midair::bridge
