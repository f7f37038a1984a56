#pragma once

#include "haptics/surface/SurfacePaint.h"

#include <Eigen/Core>

#include <memory>

namespace midair::haptics
{

/// Indexed triangle mesh in metres, of any winding, open or closed; vertices may be duplicated at
/// seams. Degenerate triangles are lines and points: lines are stored as triangles (a, b, b),
/// points as (a, a, a).
struct TriangleMesh
{
    Eigen::Matrix3Xd vertices;  ///< 3 x v, metres
    Eigen::Matrix3Xi triangles; ///< 3 x t, indices into vertices
    Eigen::VectorXf intensity;  ///< v or empty: painted haptics, 0 .. 1; factor on the target
    std::shared_ptr<const SurfacePaint> paint; ///< images, which override intensity; null: none

    /// Returns the edges of the bounding box; zero for an empty mesh.
    Eigen::Vector3d extent() const;
    /// Returns a copy, scaled uniformly to a largest extent of \a size_m (> 0, metres), with the
    /// centre of its bounding box at the origin. Throws InputError for a mesh without vertices or
    /// with all of them in one point.
    TriangleMesh scaledTo(double size_m) const;
};

} // namespace midair::haptics
