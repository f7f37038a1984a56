#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/surface/TriangleMesh.h"

#include <memory>
#include <vector>

namespace midair::bridge
{

/// How near a capsule is to a mesh.
struct NearestSpot
{
    /// skin to surface; under 0, down to minus the radius, where they overlap
    double distance_m = 0.0;
    Eigen::Vector3d onSurface = Eigen::Vector3d::Zero();
    Eigen::Vector3d onAxis = Eigen::Vector3d::Zero(); ///< of the capsule
    int triangle = -1;                                ///< -1: nothing within range
};

/// Measures the distance of capsules from one mesh, which it finds through Bullet's bounding volume
/// hierarchy and computes in double precision, without any collision margin. The mesh is a surface:
/// a capsule wholly inside a closed one is as far away as its skin is from the surface. One thread
/// at a time.
class MeshDistance
{
public:
    /// \a mesh must not be null; triangles with vertices that are not finite or not there are left
    /// out. The hierarchy is built when first searched.
    explicit MeshDistance(std::shared_ptr<const haptics::TriangleMesh> mesh);
    ~MeshDistance();

    MeshDistance(const MeshDistance&) = delete;
    MeshDistance& operator=(const MeshDistance&) = delete;

    /// The place on the surface that is nearest to \a capsule (mesh frame), if its distance is at
    /// most \a range_m (>= 0).
    NearestSpot nearest(const Capsule& capsule, double range_m) const;

    /// The area of the surface (m^2) that is inside any of \a capsules (mesh frame). Triangles are
    /// split until they are all in, all out or shorter than \a resolution_m (> 0); those are cut
    /// straight.
    double overlapArea(const std::vector<Capsule>& capsules, double resolution_m = 1e-3) const;

    const haptics::TriangleMesh& mesh() const { return *_mesh; }
    const Eigen::Vector3d& centre() const { return _centre; } ///< of the bounding box
    double radius_m() const { return _radius_m; } ///< all vertices lie within it of the centre

private:
    struct Bullet;

    std::shared_ptr<const haptics::TriangleMesh> _mesh;
    std::unique_ptr<Bullet> _bullet; ///< null: no usable triangle
    Eigen::Vector3d _centre = Eigen::Vector3d::Zero();
    double _radius_m = 0.0;
};

} // namespace midair::bridge
