#include "engine-bridge/hands/MeshDistance.h"

#include "engine-bridge/hands/SegmentDistance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace midair::bridge
{

namespace
{

/// Above the rounding of a distance, so that no triangle at exactly the limit is passed over.
constexpr double kSlack_m = 1e-12;

/// The corners of a triangle.
struct Triangle
{
    Eigen::Vector3d p, q, r;
};

/// True only if the triangle p, q, r is farther than \a limit from the capsule's axis: tells that
/// of most that are, for less than the distance costs.
bool isFarther(const Capsule& capsule,
               const Eigen::Vector3d& p,
               const Eigen::Vector3d& q,
               const Eigen::Vector3d& r,
               double limit)
{
    const Eigen::Vector3d middle = (p + q + r) / 3.0;
    const AxisDistance away(capsule.a, capsule.b, middle);
    const double nearest = std::min(
        {away.slope.dot(p - middle), away.slope.dot(q - middle), away.slope.dot(r - middle)});
    return away.distance + nearest > limit + kSlack_m;
}

/// The area of a small triangle inside the union, as if the skin were straight across it: the level
/// f = 0 of the linear interpolant cuts the share f_i^2 / ((f_i - f_j)(f_i - f_k)) off at the
/// corner i whose sign differs from the others.
double clippedArea(const Triangle& t, const std::vector<const Capsule*>& capsules)
{
    const double area = 0.5 * (t.q - t.p).cross(t.r - t.p).norm();
    const std::array<double, 3> f = {
        skinDistance(capsules, t.p), skinDistance(capsules, t.q), skinDistance(capsules, t.r)};
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
    const double pq = (t.p - t.q).squaredNorm();
    const double qr = (t.q - t.r).squaredNorm();
    const double rp = (t.r - t.p).squaredNorm();
    const double longest = std::max({pq, qr, rp});
    if (longest <= resolution_m * resolution_m) return clippedArea(t, near);
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

MeshDistance::MeshDistance(std::shared_ptr<const haptics::TriangleMesh> mesh,
                           const MeshDistance* like) :
    _mesh(std::move(mesh)),
    _tree(*_mesh, like ? &like->_tree : nullptr)
{
    if (_tree.isEmpty()) return;
    _centre = 0.5 * (_tree.low() + _tree.high());
    _radius_m = 0.5 * (_tree.high() - _tree.low()).norm();
}

NearestSpot MeshDistance::nearest(const Capsule& capsule, double range_m) const
{
    NearestSpot best;
    best.distance_m = INFINITY;
    if (!capsule.a.allFinite() || !capsule.b.allFinite()) return best;
    double limit = range_m + capsule.radius_m;
    const auto measure = [&](int t)
    {
        if (!isFinite(*_mesh, t)) return;
        const Eigen::Vector3i corner = _mesh->triangles.col(t);
        const Eigen::Vector3d p = _mesh->vertices.col(corner[0]);
        const Eigen::Vector3d q = _mesh->vertices.col(corner[1]);
        const Eigen::Vector3d r = _mesh->vertices.col(corner[2]);
        if (isFarther(capsule, p, q, r, limit)) return;
        const ClosestPair pair = closestSegmentTriangle(capsule.a, capsule.b, p, q, r);
        const double distance = pair.distance - capsule.radius_m;
        // Of triangles at the same distance takes the one with the lowest index, so that the order
        // of the hierarchy doesn't matter.
        const bool nearer =
            distance < best.distance_m || (distance == best.distance_m && t < best.triangle);
        if (distance > range_m || !nearer) return;
        best = {distance, pair.onOther, pair.onSegment, t};
        limit = pair.distance;
    };
    _tree.walk(capsule, limit, measure);
    return best;
}

double MeshDistance::overlapArea(const std::vector<Capsule>& capsules, double resolution_m) const
{
    std::vector<const Capsule*> all;
    for (const Capsule& capsule : capsules)
        if (capsule.a.allFinite() && capsule.b.allFinite()) all.push_back(&capsule);
    return _tree.areaInside(all,
                            [&](int t, const std::vector<const Capsule*>& near)
                            {
                                if (!isFinite(*_mesh, t)) return 0.0;
                                const Eigen::Vector3i corner = _mesh->triangles.col(t);
                                return areaInside({_mesh->vertices.col(corner[0]),
                                                   _mesh->vertices.col(corner[1]),
                                                   _mesh->vertices.col(corner[2])},
                                                  near,
                                                  resolution_m);
                            });
}

} // namespace midair::bridge
