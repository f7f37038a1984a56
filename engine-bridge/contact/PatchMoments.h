#pragma once

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Core>

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

} // namespace midair::bridge
