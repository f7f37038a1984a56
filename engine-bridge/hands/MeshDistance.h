#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/TriangleTree.h"
#include "haptics/surface/TriangleMesh.h"

#include <memory>
#include <vector>

namespace midair::bridge
{

/// The place of a mesh that is nearest to a capsule.
struct NearestSpot
{
    /// skin to surface; under 0, down to minus the radius, if they overlap
    double distance_m = 0.0;
    Eigen::Vector3d onSurface = Eigen::Vector3d::Zero();
    Eigen::Vector3d onAxis = Eigen::Vector3d::Zero(); ///< the nearest point of the capsule's axis
    int triangle = -1;                                ///< -1: nothing within range
};

/// Measures the distance of capsules from one mesh: finds candidates by a bounding volume hierarchy
/// and computes in double precision, without a collision margin. The mesh is a surface: for a
/// capsule wholly inside a closed one the distance is that of its skin from the surface. Any number
/// of threads may use it.
class MeshDistance
{
public:
    /// \a mesh must not be null. Leaves out triangles whose vertices are not finite or out of
    /// range. \a like: of a mesh with the same triangles, which makes it faster; may be null.
    explicit MeshDistance(std::shared_ptr<const haptics::TriangleMesh> mesh,
                          const MeshDistance* like = nullptr);

    MeshDistance(const MeshDistance&) = delete;
    MeshDistance& operator=(const MeshDistance&) = delete;

    /// The place on the surface that is nearest to \a capsule (mesh frame), if its distance is at
    /// most \a range_m (>= 0); else NearestSpot::triangle is -1.
    NearestSpot nearest(const Capsule& capsule, double range_m) const;

    /// The area of the surface (m^2) inside the union of \a capsules (mesh frame). Where the skin
    /// may cut it, splits triangles until they are wholly inside or outside or no longer than
    /// \a resolution_m (> 0); of those it takes the part on the inner side of a straight cut.
    double overlapArea(const std::vector<Capsule>& capsules, double resolution_m = 1e-3) const;

    const haptics::TriangleMesh& mesh() const { return *_mesh; }
    const TriangleTree& tree() const { return _tree; } ///< of mesh(), for searches of other kinds
    const Eigen::Vector3d& centre() const { return _centre; } ///< of the bounding box
    double radius_m() const { return _radius_m; } ///< of a sphere round centre() with all vertices

private:
    std::shared_ptr<const haptics::TriangleMesh> _mesh;
    TriangleTree _tree;
    Eigen::Vector3d _centre = Eigen::Vector3d::Zero();
    double _radius_m = 0.0;
};

} // namespace midair::bridge
