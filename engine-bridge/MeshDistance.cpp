#include "engine-bridge/MeshDistance.h"

#include "engine-bridge/SegmentDistance.h"

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

/// Boxes are searched in Bullet's floats; a metre's rounding is far below this.
constexpr double kFloatSlack_m = 1e-5;
/// The first box searched round a capsule; doubled until something is found.
constexpr double kFirstRange_m = 4e-3;

btVector3 toBullet(const Eigen::Vector3d& v)
{
    return {
        static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

class Gather : public btTriangleCallback
{
public:
    explicit Gather(std::vector<int>& found) : _found(found) {}

    void processTriangle(btVector3* /*triangle*/, int /*partId*/, int triangleIndex) override
    {
        _found.push_back(triangleIndex);
    }

private:
    std::vector<int>& _found;
};

struct Triangle
{
    Eigen::Vector3d p, q, r;
};

bool contains(const Capsule& capsule, const Eigen::Vector3d& x)
{
    return pointSegmentDistance(x, capsule.a, capsule.b) <= capsule.radius_m;
}

/// How far \a x is outside the union of \a capsules; under 0 inside.
double outside(const std::vector<const Capsule*>& capsules, const Eigen::Vector3d& x)
{
    double least = INFINITY;
    for (const Capsule* capsule : capsules)
        least =
            std::min(least, pointSegmentDistance(x, capsule->a, capsule->b) - capsule->radius_m);
    return least;
}

/// The part of a small triangle inside, as if the skin were straight across it: the level f = 0 of the linear
/// interpolant cuts the share f_i^2 / ((f_i - f_j)(f_i - f_k)) off at the corner i that stands alone.
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

/// The part of the triangle inside the union of \a capsules, m^2. \a near: those that may reach it.
double areaInside(const Triangle& t, const std::vector<const Capsule*>& near, double resolution_m)
{
    std::vector<const Capsule*> reaching;
    for (const Capsule* capsule : near)
    {
        // Convex: three corners inside are the whole triangle inside.
        if (contains(*capsule, t.p) && contains(*capsule, t.q) && contains(*capsule, t.r))
            return 0.5 * (t.q - t.p).cross(t.r - t.p).norm();
        if (closestSegmentTriangle(capsule->a, capsule->b, t.p, t.q, t.r).distance <
            capsule->radius_m)
            reaching.push_back(capsule);
    }
    if (reaching.empty()) return 0.0;
    // Halved across the longest edge, so that needles don't stay needles.
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

/// The hierarchy reads vertices and indices where they are: in the mesh, and in `triangles`.
struct MeshDistance::Bullet
{
    Eigen::Matrix3Xi triangles;
    std::vector<int> original; ///< triangle of the mesh for each of `triangles`
    btTriangleIndexVertexArray arrays;
    std::unique_ptr<btBvhTriangleMeshShape> shape; ///< null until searched

    void build(const haptics::TriangleMesh& mesh);
};

void MeshDistance::Bullet::build(const haptics::TriangleMesh& mesh)
{
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(triangles.cols());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(triangles.data());
    part.m_triangleIndexStride = 3 * sizeof(int);
    part.m_numVertices = static_cast<int>(mesh.vertices.cols());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.vertices.data());
    part.m_vertexStride = 3 * sizeof(double);
    part.m_vertexType = PHY_DOUBLE;
    arrays.addIndexedMesh(part, PHY_INTEGER);
    shape = std::make_unique<btBvhTriangleMeshShape>(&arrays, true);
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

void MeshDistance::candidates(const Eigen::Vector3d& low,
                              const Eigen::Vector3d& high,
                              std::vector<int>& triangles) const
{
    triangles.clear();
    if (!_bullet->shape) _bullet->build(*_mesh);
    Gather gather(triangles);
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(kFloatSlack_m);
    _bullet->shape->processAllTriangles(&gather, toBullet(low - slack), toBullet(high + slack));
    for (int& triangle : triangles)
        triangle = _bullet->original[static_cast<std::size_t>(triangle)];
}

NearestSpot MeshDistance::nearest(const Capsule& capsule, double range_m) const
{
    NearestSpot best;
    best.distance_m = INFINITY;
    if (!_bullet || !capsule.a.allFinite() || !capsule.b.allFinite()) return best;
    // Nothing of the mesh lies outside this, so no larger box is worth searching.
    const double farthest =
        pointSegmentDistance(_centre, capsule.a, capsule.b) + _radius_m - capsule.radius_m;
    if (farthest - 2.0 * _radius_m > range_m) return best;
    const double widest = std::min(range_m, std::max(0.0, farthest));
    double reach = std::min(kFirstRange_m, widest);
    for (;;)
    {
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(capsule.radius_m + reach);
        candidates(
            capsule.a.cwiseMin(capsule.b) - margin, capsule.a.cwiseMax(capsule.b) + margin, _found);
        for (const int t : _found)
        {
            const Eigen::Vector3i corner = _mesh->triangles.col(t);
            const ClosestPair pair = closestSegmentTriangle(capsule.a,
                                                            capsule.b,
                                                            _mesh->vertices.col(corner[0]),
                                                            _mesh->vertices.col(corner[1]),
                                                            _mesh->vertices.col(corner[2]));
            const double distance = pair.distance - capsule.radius_m;
            // Of equals the first triangle, in whatever order the hierarchy gives them.
            if (distance > best.distance_m || (distance == best.distance_m && t > best.triangle))
                continue;
            best = {distance, pair.onOther, pair.onSegment, t};
        }
        if (best.distance_m <= reach || reach >= widest) break;
        reach = std::min(2.0 * reach, widest);
    }
    if (best.distance_m > range_m)
    {
        best = NearestSpot();
        best.distance_m = INFINITY;
    }
    return best;
}

double MeshDistance::overlapArea(const std::vector<Capsule>& capsules, double resolution_m) const
{
    if (!_bullet) return 0.0;
    std::vector<int> triangles;
    std::vector<const Capsule*> all;
    for (const Capsule& capsule : capsules)
    {
        if (!capsule.a.allFinite() || !capsule.b.allFinite()) continue;
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(capsule.radius_m);
        candidates(
            capsule.a.cwiseMin(capsule.b) - margin, capsule.a.cwiseMax(capsule.b) + margin, _found);
        triangles.insert(triangles.end(), _found.begin(), _found.end());
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
