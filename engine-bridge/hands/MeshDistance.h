#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// A triangle of a surface.
struct SurfaceTriangle
{
    Eigen::Vector3d p, q, r; ///< metres
};

/// Moments of a part of a surface, for its centre, spread and mean normal.
struct PatchMoments
{
    double area_m2 = 0.0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();   ///< integral of x dA, m^3
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< integral of x x^T dA, m^4
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< integral of the unit normal, m^2
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero(); ///< integral of n n^T, m^2

    /// Adds a whole triangle with the unit normal \a n, exactly: for a triangle with corners v_k
    /// and their sum s the integral of x x^T is A/12 (sum v_k v_k^T + s s^T).
    void add(const SurfaceTriangle& t, const Eigen::Vector3d& n);
    void add(const PatchMoments& other);

    Eigen::Vector3d centre() const { return first / area_m2; } ///< area_m2 > 0
    Eigen::Matrix3d covariance() const;                        ///< m^2; area_m2 > 0
};

/// Adds the part of \a t inside the union of \a capsules to \a sum; \a n is its unit normal.
///
/// Triangles that the skin may cut are halved until they are no longer than \a resolution_m (> 0)
/// or entirely on one side; the remaining ones are cut along a straight line between the places
/// where the skin crosses the edges. Parts cut off by any of \a clips (n, d; cut off at n x + d <
/// 0) are left out, at that resolution.
void addInside(const SurfaceTriangle& t,
               const Eigen::Vector3d& n,
               const std::vector<const Capsule*>& capsules,
               const std::vector<Eigen::Vector4d>& clips,
               double resolution_m,
               PatchMoments& sum);

/// Bounding volume hierarchy of a mesh's triangles: boxes, and the surface area of each.
///
/// Exact: a search by lowerBound() gives the same result as testing every triangle. Ignores
/// triangles whose vertices are not finite or out of range.
class TriangleTree
{
public:
    /// \a mesh must outlive the tree. \a like: a tree of the same triangles at other places;
    /// reusing its order is faster. If it is null or differs too much, the order is computed again.
    TriangleTree(const haptics::TriangleMesh& mesh, const TriangleTree* like);

    bool isEmpty() const { return _isEmpty; }
    const Eigen::AlignedBox3d& box() const { return _boxes.front(); } ///< of the whole mesh

    /// Calls \a visit(t) for every triangle that may be within \a limit of the capsule's axis,
    /// probably near ones first; visit may lower the limit.
    template<class Visit>
    void walk(const Capsule& capsule, const double& limit, const Visit& visit) const
    {
        if (!_isEmpty && lowerBound(capsule, 0) <= limit) walkFrom(0, capsule, limit, visit);
    }

    /// Returns the surface area inside the union of \a capsules: calls \a areaOf(t, near) for
    /// triangles that the skin may cut, with the capsules that may reach them.
    template<class AreaOf>
    double areaInside(const std::vector<const Capsule*>& capsules, const AreaOf& areaOf) const
    {
        return _isEmpty ? 0.0 : areaFrom(0, capsules, areaOf);
    }

private:
    /// A node; its left child follows it.
    struct Link
    {
        int right = 0; ///< the right child; 0: a leaf
        int first = 0; ///< of a leaf, the first of its triangles in Order::triangles
        int count = 0;
    };
    /// Shared by trees of the same triangles.
    struct Order
    {
        std::vector<int> triangles; ///< with valid indices, leaf by leaf
        std::vector<Link> links;
        Eigen::Index ofTriangles = 0; ///< of the mesh
        double size_m = 0.0;          ///< sizeOf() when it was computed
    };
    struct Box : Eigen::AlignedBox3d
    {
        double area = 0.0; ///< of all triangles in it
    };
    struct Builder;

    void fit();
    Box boxOf(const Link& leaf) const;
    double sizeOf() const;
    double lowerBound(const Capsule& capsule, int node) const;
    bool isInside(int node, const Capsule& capsule) const;

    template<class Visit>
    void walkFrom(int node, const Capsule& capsule, const double& limit, const Visit& visit) const
    {
        const Link& link = _order->links[static_cast<std::size_t>(node)];
        if (link.right == 0)
        {
            for (int i = link.first; i < link.first + link.count; ++i)
                visit(_order->triangles[static_cast<std::size_t>(i)]);
            return;
        }
        const int left = node + 1;
        const double toLeft = lowerBound(capsule, left);
        const double toRight = lowerBound(capsule, link.right);
        const bool leftFirst = toLeft <= toRight;
        if (std::min(toLeft, toRight) <= limit)
            walkFrom(leftFirst ? left : link.right, capsule, limit, visit);
        if (std::max(toLeft, toRight) <= limit)
            walkFrom(leftFirst ? link.right : left, capsule, limit, visit);
    }

    template<class AreaOf>
    double
    areaFrom(int node, const std::vector<const Capsule*>& capsules, const AreaOf& areaOf) const
    {
        std::vector<const Capsule*> near;
        for (const Capsule* capsule : capsules)
        {
            if (isInside(node, *capsule)) return _boxes[static_cast<std::size_t>(node)].area;
            if (lowerBound(*capsule, node) <= capsule->radius_m) near.push_back(capsule);
        }
        if (near.empty()) return 0.0;
        const Link& link = _order->links[static_cast<std::size_t>(node)];
        double area = 0.0;
        if (link.right > 0)
            return areaFrom(node + 1, near, areaOf) + areaFrom(link.right, near, areaOf);
        for (int i = link.first; i < link.first + link.count; ++i)
            area += areaOf(_order->triangles[static_cast<std::size_t>(i)], near);
        return area;
    }

    const haptics::TriangleMesh& _mesh;
    std::shared_ptr<const Order> _order;
    std::vector<Box> _boxes; ///< of each node
    bool _isEmpty = true;
};

/// Returns true if all vertices of the triangle \a t, which has valid indices, are finite.
bool isFinite(const haptics::TriangleMesh& mesh, int t);

/// The place of a mesh nearest to a capsule.
struct NearestSpot
{
    /// skin to surface; below 0, down to minus the radius, if they overlap
    double distance_m = 0.0;
    Eigen::Vector3d onSurface = Eigen::Vector3d::Zero();
    Eigen::Vector3d onAxis = Eigen::Vector3d::Zero(); ///< the nearest point of the capsule's axis
    int triangle = -1;                                ///< -1: nothing within range
};

/// Measures the distance of capsules from one mesh: finds candidates by a bounding volume hierarchy
/// and computes in double precision, without a collision margin. The mesh is a surface: for a
/// capsule entirely inside a closed mesh the distance is that of its skin from the surface. Any
/// number of threads may use it.
class MeshDistance
{
public:
    /// \a mesh must not be null. Ignores triangles whose vertices are not finite or out of range.
    /// \a like: of a mesh with the same triangles, which is faster; may be null.
    explicit MeshDistance(std::shared_ptr<const haptics::TriangleMesh> mesh,
                          const MeshDistance* like = nullptr);

    MeshDistance(const MeshDistance&) = delete;
    MeshDistance& operator=(const MeshDistance&) = delete;

    /// Returns the place on the surface nearest to \a capsule (mesh frame) if its distance is at
    /// most \a range_m (>= 0); else NearestSpot::triangle is -1.
    NearestSpot nearest(const Capsule& capsule, double range_m) const;

    /// Returns the area of the surface (m^2) inside the union of \a capsules (mesh frame). Splits
    /// triangles that the skin may cut until they are entirely inside or outside, or no longer than
    /// \a resolution_m (> 0); these are cut along a straight line.
    double overlapArea(const std::vector<Capsule>& capsules, double resolution_m = 1e-3) const;

    const haptics::TriangleMesh& mesh() const { return *_mesh; }
    const TriangleTree& tree() const { return _tree; }        ///< of mesh(), for other searches
    const Eigen::Vector3d& centre() const { return _centre; } ///< of the bounding box
    double radius_m() const { return _radius_m; } ///< of a sphere round centre() with all vertices

private:
    std::shared_ptr<const haptics::TriangleMesh> _mesh;
    TriangleTree _tree;
    Eigen::Vector3d _centre = Eigen::Vector3d::Zero();
    double _radius_m = 0.0;
};

} // namespace midair::bridge
