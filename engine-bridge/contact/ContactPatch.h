#pragma once

#include "engine-bridge/hands/MeshDistance.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// Contact area of a hand and an object: the part of the object's surface inside one bone's
/// capsule, or inside those of several bones that feel like one place. In the array frame.
///
/// The ellipse has the patch's covariance: semi-axes 2 sqrt(eigenvalue), because a uniform ellipse
/// has the standard deviation semi-axis / 2 along each axis.
struct ContactPatch
{
    std::uint64_t object = 0; ///< HapticObject::touchId()
    int hand = 0;             ///< Hand::id
    std::vector<int> bones;   ///< ascending, at least one

    Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< m; area-weighted
    /// unit length, out of the object: the side from which the finger came
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero(); ///< m^2
    Eigen::Vector3d major = Eigen::Vector3d::UnitX();     ///< unit length, across normal
    Eigen::Vector3d minor = Eigen::Vector3d::UnitY();     ///< normal x major
    double semiMajor_m = 0.0;
    double semiMinor_m = 0.0;
    double area_m2 = 0.0;
    /// m; from the centre along -normal to the skin: depth of the finger in the object
    double depth_m = 0.0;
    /// The finger entered a thin object from its other side and leaves it here: of such a pair only
    /// the entry presses.
    bool isExit = false;

    std::vector<Capsule> own;                                     ///< of these bones
    std::shared_ptr<const std::vector<Capsule>> skin;             ///< of the whole hand; null: own
    Eigen::Isometry3d objectPose = Eigen::Isometry3d::Identity(); ///< mesh -> array frame
    std::shared_ptr<const MeshDistance> surface;                  ///< the mesh; may be null
};

/// Sets centre, covariance, axes and area of \a patch from \a moments, whose area is above 0, and
/// its normal to \a normal (unit length).
void setShape(ContactPatch& patch, const PatchMoments& moments, const Eigen::Vector3d& normal);

/// Returns the place on the skin under \a place, along the patch's -normal: the end of the capsules
/// there. Places more than 0.8 radii beside all of the patch's capsules are first moved under the
/// nearest one, so that every place has one, on the contact's side and where the skin is at most 53
/// degrees steep. \a patch has at least one own capsule.
Eigen::Vector3d skinUnder(const ContactPatch& patch, const Eigen::Vector3d& place);

/// Returns the distance from \a place along -\a normal to the end of \a capsule, m; NaN if it is
/// beside it.
double depthIn(const Capsule& capsule, const Eigen::Vector3d& place, const Eigen::Vector3d& normal);

} // namespace midair::bridge
