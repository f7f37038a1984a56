#pragma once

#include <cstdint>

namespace midair::bridge
{

/// Why there is no contact, or why one began anew.
enum class ContactReason
{
    NONE,
    TIME_NOT_FINITE,     ///< the time isn't a number or runs backwards
    JOINT_NOT_FINITE,    ///< a joint that counts as tracked has a place that isn't a number
    RADIUS_OUT_OF_RANGE, ///< a joint's radius isn't a number above 0 and up to kMostRadius_m
    POSE_NOT_FINITE,     ///< an object's pose isn't a number
    MESH_NOT_READY,      ///< its mesh is still being prepared
    NO_AREA,             ///< what is touched has no area: lines, points, triangles without area
    MATERIAL_INVALID,    ///< a number of its material is out of range
    HAND_JUMPED          ///< the contact moved farther at once than a hand does; it begins anew
};

/// Returns a sentence for messages; "" for NONE.
const char* contactReasonText(ContactReason reason);

/// Where a reason holds.
struct ContactNote
{
    ContactReason reason = ContactReason::NONE;
    int hand = 0;             ///< Hand::id
    int bone = -1;            ///< 0 .. kHandBones - 1, -1: none in particular
    std::uint64_t object = 0; ///< HapticObject::touchId(), 0: none in particular
};

/// Largest radius of a joint, m: some five times that of a palm's.
constexpr double kMostRadius_m = 0.1;

} // namespace midair::bridge
