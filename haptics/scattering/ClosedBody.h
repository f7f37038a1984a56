#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// The surface of a closed body in plane triangles, small enough for waves.
struct ClosedBody
{
    Eigen::Matrix3Xd corners; ///< 3 x 3n, metres: of each triangle one after the other,
                              ///< counter-clockwise from outside
    Eigen::Matrix3Xd centres; ///< 3 x n, metres
    Eigen::Matrix3Xd normals; ///< 3 x n, unit length, out of the body
    Eigen::VectorXd areas;    ///< n, m^2

    Eigen::Index size() const { return areas.size(); }
    /// Returns the side, m, of an equilateral triangle of the mean area.
    double meanSide_m() const;

    /// Divides the triangles of \a mesh until no edge is longer than \a longest_m (> 0). Throws
    /// InputError, which names the reason, for a mesh that isn't closed, whose faces are wound
    /// differently, with faces on each other, lines or points, and for more than \a mostElements
    /// triangles.
    static ClosedBody from(const TriangleMesh& mesh, double longest_m, Eigen::Index mostElements);

    /// Returns the number of triangles that from() makes, at most \a most; doesn't check the mesh.
    static Eigen::Index count(const TriangleMesh& mesh, double longest_m, Eigen::Index most);

    /// Returns true if \a point (metres) is inside, by the solid angle of the surface (Van
    /// Oosterom, Strackee 1983, 10.1109/TBME.1983.325207).
    bool isInside(const Eigen::Vector3d& point) const;
};

} // namespace midair::haptics
