#pragma once

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// A triangle of a surface.
struct SurfaceTriangle
{
    Eigen::Vector3d p, q, r; ///< metres
};

/// Sums over a part of a surface, from which its centre, spread and mean normal follow.
struct PatchMoments
{
    double area_m2 = 0.0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();   ///< integral of x dA, m^3
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< integral of x x^T dA, m^4
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< integral of the unit normal, m^2
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero(); ///< integral of n n^T, m^2

    /// Adds a whole triangle with the unit normal \a n, exactly: of a triangle with corners v_k and
    /// sum s the integral of x x^T is A/12 (sum v_k v_k^T + s s^T).
    void add(const SurfaceTriangle& t, const Eigen::Vector3d& n);
    void add(const PatchMoments& other);

    Eigen::Vector3d centre() const { return first / area_m2; } ///< area_m2 > 0
    Eigen::Matrix3d covariance() const;                        ///< m^2; area_m2 > 0
};

/// Adds the part of \a t inside the union of \a capsules to \a sum; \a n is its unit normal.
///
/// Triangles that the skin may cut are halved until they are no longer than \a resolution_m (> 0)
/// or wholly on one side; of these the part inside is bounded by a straight line between the places
/// where the skin crosses the edges. What any of \a clips (n, d; cut off at n x + d < 0) cuts off
/// is left out, to that resolution.
void addInside(const SurfaceTriangle& t,
               const Eigen::Vector3d& n,
               const std::vector<const Capsule*>& capsules,
               const std::vector<Eigen::Vector4d>& clips,
               double resolution_m,
               PatchMoments& sum);

class MeshDistance;

/// Where a hand touches an object: the part of the object's surface inside one bone's capsule, or
/// inside those of several bones that feel like one place. In the array frame.
///
/// The ellipse has the patch's covariance: semi-axes 2 sqrt(eigenvalue), since a uniform ellipse
/// has the standard deviation semi-axis / 2 along each.
struct ContactPatch
{
    std::uint64_t object = 0; ///< HapticObject::touchId()
    int hand = 0;             ///< Hand::id
    std::vector<int> bones;   ///< ascending, at least one

    Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< m; area-weighted
    /// unit length, out of the object: where the finger came from
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero(); ///< m^2
    Eigen::Vector3d major = Eigen::Vector3d::UnitX();     ///< unit length, across normal
    Eigen::Vector3d minor = Eigen::Vector3d::UnitY();     ///< normal x major
    double semiMajor_m = 0.0;
    double semiMinor_m = 0.0;
    double area_m2 = 0.0;
    /// m; from the centre along -normal to the skin: how deep the finger is in the object
    double depth_m = 0.0;
    /// The finger went in through the other side of a thin object, and out here: of such a pair
    /// only the other one presses.
    bool isExit = false;

    std::vector<Capsule> own;                         ///< those of bones
    std::shared_ptr<const std::vector<Capsule>> skin; ///< those of the whole hand; null: own
    Eigen::Isometry3d objectPose = Eigen::Isometry3d::Identity(); ///< mesh -> array frame
    std::shared_ptr<const MeshDistance> surface;                  ///< the mesh; may be null
};

/// Sets centre, covariance, axes and area of \a patch from \a moments, whose area is above 0, and
/// its normal to \a normal (unit length).
void setShape(ContactPatch& patch, const PatchMoments& moments, const Eigen::Vector3d& normal);

/// Returns the place on the skin under \a place, along the patch's -normal: the end of the capsules
/// there. Places that are more than 0.8 radii beside all of the patch's capsules are moved under
/// the nearest of them first, so that there is one for any place, on the contact's side and where
/// the skin is no steeper than 53 degrees. \a patch has at least one own capsule.
Eigen::Vector3d skinUnder(const ContactPatch& patch, const Eigen::Vector3d& place);

/// Returns how far it is from \a place along -\a normal to the end of \a capsule, m; NaN if it is
/// beside it.
double depthIn(const Capsule& capsule, const Eigen::Vector3d& place, const Eigen::Vector3d& normal);

} // namespace midair::bridge
