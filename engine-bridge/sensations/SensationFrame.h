#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/contact/ContactPatch.h"
#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/MeshDistance.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>

namespace midair::bridge
{

/// The frame in which a sensation is at one moment.
struct SensationFrame
{
    /// metres of the pattern -> array; a rotation and a translation, mirrored for left hands
    Eigen::Affine3d toArray = Eigen::Affine3d::Identity();
    /// samples are moved onto it, along with their heights; null: they stay
    std::shared_ptr<const MeshDistance> surface;
    Eigen::Isometry3d surfacePose = Eigen::Isometry3d::Identity(); ///< mesh -> array

    /// Returns where a sample at \a pattern_m is, m, array frame.
    Eigen::Vector3d at(const Eigen::Vector3d& pattern_m) const;
    /// Returns the direction of the pattern's z, of length 1, in the array frame.
    Eigen::Vector3d normal() const { return toArray.linear().col(2); }
};

/// Returns the frame of \a joint (HandJointName) of a hand: on its skin, y along the fingers, z out
/// of the palm, x of left hands mirrored. \a hand: Hand::id; -1: any, and set to the found one.
/// None: it isn't tracked.
std::optional<SensationFrame> frameOfHand(const HandFrame& hands, int joint, int& hand);

/// Returns the frame on the surface at the place of \a touch: z is its normal, x the object's, as
/// far as it lies in the surface.
SensationFrame frameOnSurface(const ContactPatch& touch);

/// The same under the object's origin, at the nearest place of the surface.
SensationFrame frameUnderOrigin(const HapticObject& object,
                                std::shared_ptr<const MeshDistance> surface);

} // namespace midair::bridge
