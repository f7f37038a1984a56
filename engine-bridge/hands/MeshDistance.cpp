#include "engine-bridge/hands/MeshDistance.h"

#include "engine-bridge/hands/SegmentDistance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

namespace midair::bridge
{

namespace
{

/// Units per metre of the hierarchy: Bullet enlarges every box by up to 0.002 units, which with
/// metres would make the boxes of a fine mesh overlap.
constexpr double kBulletUnits = 1000.0;
/// Margin of boxes: Bullet rounds them outwards to 16 bits, but to the nearest float before.
constexpr double kFloatSlack_m = 1e-6;

/// The corners of a triangle.
struct Triangle
{
    Eigen::Vector3d p, q, r;
};

bool contains(const Capsule& capsule, const Eigen::Vector3d& x)
{
    return pointSegmentDistance(x, capsule.a, capsule.b) <= capsule.radius_m;
}

/// Distance of \a x from the union of \a capsules; under 0: inside.
double outside(const std::vector<const Capsule*>& capsules, const Eigen::Vector3d& x)
{
    double least = INFINITY;
    for (const Capsule* capsule : capsules)
        least =
            std::min(least, pointSegmentDistance(x, capsule->a, capsule->b) - capsule->radius_m);
    return least;
}

/// The area of a small triangle inside the union, as if the skin were straight across it: the level
/// f = 0 of the linear interpolant cuts the share f_i^2 / ((f_i - f_j)(f_i - f_k)) off at the
/// corner i whose sign differs from the others.
double clippedArea(const Triangle& t, const std::vector<const Capsule*>& capsules)
{
    const double area = 0.5 * (t.q - t.p).cross(t.r - t.p).norm();
    const std::array<double, 3> f = {
        outside(capsules, t.p), outside(capsules, t.q), outside(capsules, t.r)};
    const auto in = std::count_if(f.begin(), f.end(), [](double value) { return value < 0.0; });
    if (in == 0) return 0.0;
    if (in == 3) return area;
    std::size_t alone = 0;
    while ((f[alone] < 0.0) != (in == 1))
        ++alone;
    const double fi = f[alone];
    const double corner = fi * fi / ((fi - f[(alone + 1) % 3]) * (fi - f[(alone + 2) % 3]));
    return in == 1 ? corner * area : (1.0 - corner) * area;
}

/// The area (m^2) of the triangle that is inside the union of \a capsules. \a near are those that
/// may reach it.
double areaInside(const Triangle& t, const std::vector<const Capsule*>& near, double resolution_m)
{
    std::vector<const Capsule*> reaching;
    for (const Capsule* capsule : near)
    {
        // A capsule is convex: with three corners inside, the whole triangle is.
        if (contains(*capsule, t.p) && contains(*capsule, t.q) && contains(*capsule, t.r))
            return 0.5 * (t.q - t.p).cross(t.r - t.p).norm();
        if (closestSegmentTriangle(capsule->a, capsule->b, t.p, t.q, t.r).distance <
            capsule->radius_m)
            reaching.push_back(capsule);
    }
    if (reaching.empty()) return 0.0;
    // Halves the longest edge, so that thin triangles become compact.
    const double pq = (t.p - t.q).squaredNorm();
    const double qr = (t.q - t.r).squaredNorm();
    const double rp = (t.r - t.p).squaredNorm();
    const double longest = std::max({pq, qr, rp});
    if (longest <= resolution_m * resolution_m) return clippedArea(t, reaching);
    Triangle turned = t;
    if (qr == longest)
        turned = {t.q, t.r, t.p};
    else if (rp == longest)
        turned = {t.r, t.p, t.q};
    const Eigen::Vector3d middle = 0.5 * (turned.p + turned.q);
    return areaInside({turned.p, middle, turned.r}, reaching, resolution_m) +
           areaInside({middle, turned.q, turned.r}, reaching, resolution_m);
}

} // namespace

/// Bullet's hierarchy of the mesh and its search, which visits the nearer child first and skips
/// boxes that are too far.
struct MeshDistance::Bullet
{
    Eigen::Matrix3Xf vertices; ///< of the mesh, in Bullet's units
    Eigen::Matrix3Xi triangles;
    std::vector<int> original; ///< triangle of the mesh for each of `triangles`
    btTriangleIndexVertexArray arrays;
    std::unique_ptr<btBvhTriangleMeshShape> shape; ///< null until the first search

    void build(const haptics::TriangleMesh& mesh);
    double lowerBound(const Capsule& capsule, int node) const;
    template<class Visit>
    void walk(const Capsule& capsule, int node, const double& limit, const Visit& visit) const;

    const QuantizedNodeArray& nodes() const
    {
        return shape->getOptimizedBvh()->getQuantizedNodeArray();
    }
};

void MeshDistance::Bullet::build(const haptics::TriangleMesh& mesh)
{
    vertices = (kBulletUnits * mesh.vertices).cast<float>();
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(triangles.cols());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(triangles.data());
    part.m_triangleIndexStride = 3 * sizeof(int);
    part.m_numVertices = static_cast<int>(vertices.cols());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices.data());
    part.m_vertexStride = 3 * sizeof(float);
    part.m_vertexType = PHY_FLOAT;
    arrays.addIndexedMesh(part, PHY_INTEGER);
    shape = std::make_unique<btBvhTriangleMeshShape>(&arrays, true);
}

/// A lower bound on the distance of the node's box from the capsule's axis: the larger of the
/// distances box to box and sphere to axis.
double MeshDistance::Bullet::lowerBound(const Capsule& capsule, int node) const
{
    const btQuantizedBvhNode& quantized = nodes()[node];
    const btOptimizedBvh& bvh = *shape->getOptimizedBvh();
    const btVector3 low = bvh.unQuantize(quantized.m_quantizedAabbMin);
    const btVector3 high = bvh.unQuantize(quantized.m_quantizedAabbMax);
    const Eigen::Vector3d boxLow = Eigen::Vector3d(low.x(), low.y(), low.z()) / kBulletUnits;
    const Eigen::Vector3d boxHigh = Eigen::Vector3d(high.x(), high.y(), high.z()) / kBulletUnits;
    const Eigen::Vector3d apart = (boxLow - capsule.a.cwiseMax(capsule.b))
                                      .cwiseMax(capsule.a.cwiseMin(capsule.b) - boxHigh)
                                      .cwiseMax(0.0);
    const double ball = pointSegmentDistance(0.5 * (boxLow + boxHigh), capsule.a, capsule.b) -
                        0.5 * (boxHigh - boxLow).norm();
    return std::max(apart.norm(), ball) - kFloatSlack_m;
}

/// Calls \a visit with every triangle whose box may be within \a limit of the axis; visit may lower
/// the limit.
template<class Visit>
void MeshDistance::Bullet::walk(const Capsule& capsule,
                                int node,
                                const double& limit,
                                const Visit& visit) const
{
    const btQuantizedBvhNode& here = nodes()[node];
    if (here.isLeafNode())
    {
        visit(original[static_cast<std::size_t>(here.getTriangleIndex())]);
        return;
    }
    // Children follow their parent in memory; an escape index says how long the left subtree is.
    const int left = node + 1;
    const int right = nodes()[left].isLeafNode() ? left + 1 : left + nodes()[left].getEscapeIndex();
    const double toLeft = lowerBound(capsule, left);
    const double toRight = lowerBound(capsule, right);
    const bool leftFirst = toLeft <= toRight;
    if (std::min(toLeft, toRight) <= limit) walk(capsule, leftFirst ? left : right, limit, visit);
    if (std::max(toLeft, toRight) <= limit) walk(capsule, leftFirst ? right : left, limit, visit);
}

MeshDistance::MeshDistance(std::shared_ptr<const haptics::TriangleMesh> mesh) :
    _mesh(std::move(mesh))
{
    assert(_mesh);
    auto bullet = std::make_unique<Bullet>();
    bullet->triangles.resize(3, _mesh->triangles.cols());
    bullet->original.reserve(static_cast<std::size_t>(_mesh->triangles.cols()));
    const auto vertices = _mesh->vertices.cols();
    Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY);
    Eigen::Vector3d high = -low;
    Eigen::Index kept = 0;
    for (Eigen::Index t = 0; t < _mesh->triangles.cols(); ++t)
    {
        const Eigen::Vector3i corners = _mesh->triangles.col(t);
        if (corners.minCoeff() < 0 || corners.maxCoeff() >= vertices) continue;
        bool finite = true;
        for (const int corner : corners)
            finite = finite && _mesh->vertices.col(corner).allFinite();
        if (!finite) continue;
        for (const int corner : corners)
        {
            low = low.cwiseMin(_mesh->vertices.col(corner));
            high = high.cwiseMax(_mesh->vertices.col(corner));
        }
        bullet->triangles.col(kept++) = corners;
        bullet->original.push_back(static_cast<int>(t));
    }
    if (kept == 0) return;
    bullet->triangles.conservativeResize(3, kept);
    _centre = 0.5 * (low + high);
    _radius_m = 0.5 * (high - low).norm();
    _bullet = std::move(bullet);
}

MeshDistance::~MeshDistance() = default;

NearestSpot MeshDistance::nearest(const Capsule& capsule, double range_m) const
{
    NearestSpot best;
    best.distance_m = INFINITY;
    if (!_bullet || !capsule.a.allFinite() || !capsule.b.allFinite()) return best;
    const double gap = pointSegmentDistance(_centre, capsule.a, capsule.b) - _radius_m;
    double limit = range_m + capsule.radius_m;
    if (gap > limit) return best;
    if (!_bullet->shape) _bullet->build(*_mesh);
    const auto measure = [&](int t)
    {
        const Eigen::Vector3i corner = _mesh->triangles.col(t);
        const ClosestPair pair = closestSegmentTriangle(capsule.a,
                                                        capsule.b,
                                                        _mesh->vertices.col(corner[0]),
                                                        _mesh->vertices.col(corner[1]),
                                                        _mesh->vertices.col(corner[2]));
        const double distance = pair.distance - capsule.radius_m;
        // Of triangles at the same distance takes the one with the lowest index, so that the order
        // of the hierarchy doesn't matter.
        const bool nearer =
            distance < best.distance_m || (distance == best.distance_m && t < best.triangle);
        if (distance > range_m || !nearer) return;
        best = {distance, pair.onOther, pair.onSegment, t};
        limit = pair.distance;
    };
    _bullet->walk(capsule, 0, limit, measure);
    return best;
}

double MeshDistance::overlapArea(const std::vector<Capsule>& capsules, double resolution_m) const
{
    if (!_bullet) return 0.0;
    if (!_bullet->shape) _bullet->build(*_mesh);
    std::vector<int> triangles;
    std::vector<const Capsule*> all;
    for (const Capsule& capsule : capsules)
    {
        if (!capsule.a.allFinite() || !capsule.b.allFinite()) continue;
        _bullet->walk(capsule, 0, capsule.radius_m, [&](int t) { triangles.push_back(t); });
        all.push_back(&capsule);
    }
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    double area = 0.0;
    for (const int t : triangles)
    {
        const Eigen::Vector3i corner = _mesh->triangles.col(t);
        area += areaInside({_mesh->vertices.col(corner[0]),
                            _mesh->vertices.col(corner[1]),
                            _mesh->vertices.col(corner[2])},
                           all,
                           resolution_m);
    }
    return area;
}

} // namespace midair::bridge
