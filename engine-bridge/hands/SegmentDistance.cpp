#include "engine-bridge/hands/SegmentDistance.h"

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

double clamp01(double value)
{
    return std::clamp(value, 0.0, 1.0);
}

/// True if \a x, which lies in the triangle's plane, is inside it. \a normal need not have unit
/// length.
bool inside(const Eigen::Vector3d& x,
            const Eigen::Vector3d& p,
            const Eigen::Vector3d& q,
            const Eigen::Vector3d& r,
            const Eigen::Vector3d& normal)
{
    return (q - p).cross(x - p).dot(normal) >= 0.0 && (r - q).cross(x - q).dot(normal) >= 0.0 &&
           (p - r).cross(x - r).dot(normal) >= 0.0;
}

void keepNearer(ClosestPair& best, const ClosestPair& other)
{
    if (other.distance < best.distance) best = other;
}

} // namespace

ClosestPair closestSegments(const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c,
                            const Eigen::Vector3d& d)
{
    const Eigen::Vector3d u = b - a;
    const Eigen::Vector3d v = d - c;
    const Eigen::Vector3d w = a - c;
    const double uu = u.squaredNorm();
    const double vv = v.squaredNorm();
    const double uw = u.dot(w);
    const double vw = v.dot(w);
    const double uv = u.dot(v);
    double s = 0.0;
    double t = 0.0;
    if (uu > 0.0 && vv > 0.0)
    {
        const double determinant = uu * vv - uv * uv;
        // For parallel segments several s are equally near; uses the end a.
        s = determinant > 1e-14 * uu * vv ? clamp01((uv * vw - uw * vv) / determinant) : 0.0;
        t = (uv * s + vw) / vv;
        if (t < 0.0 || t > 1.0)
        {
            t = clamp01(t);
            s = clamp01((uv * t - uw) / uu);
        }
    }
    else if (uu > 0.0)
        s = clamp01(-uw / uu);
    else if (vv > 0.0)
        t = clamp01(vw / vv);
    ClosestPair pair;
    pair.onSegment = a + s * u;
    pair.onOther = c + t * v;
    pair.distance = (pair.onSegment - pair.onOther).norm();
    return pair;
}

ClosestPair closestSegmentTriangle(const Eigen::Vector3d& a,
                                   const Eigen::Vector3d& b,
                                   const Eigen::Vector3d& p,
                                   const Eigen::Vector3d& q,
                                   const Eigen::Vector3d& r)
{
    ClosestPair best = closestSegments(a, b, p, q);
    keepNearer(best, closestSegments(a, b, q, r));
    keepNearer(best, closestSegments(a, b, r, p));
    const Eigen::Vector3d normal = (q - p).cross(r - p);
    const double area2 = normal.squaredNorm();
    if (!(area2 > 0.0)) return best;
    const double heightA = normal.dot(a - p);
    const double heightB = normal.dot(b - p);
    if (heightA * heightB < 0.0)
    {
        const Eigen::Vector3d crossing = a + heightA / (heightA - heightB) * (b - a);
        if (inside(crossing, p, q, r, normal)) return {crossing, crossing, 0.0};
    }
    for (const Eigen::Vector3d* end : {&a, &b})
    {
        const double height = normal.dot(*end - p) / area2; // in units of the normal
        const Eigen::Vector3d foot = *end - height * normal;
        if (inside(foot, p, q, r, normal)) keepNearer(best, {*end, foot, (*end - foot).norm()});
    }
    return best;
}

AxisDistance::AxisDistance(const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b,
                           const Eigen::Vector3d& place)
{
    const Eigen::Vector3d u = b - a;
    const double uu = u.squaredNorm();
    const double t = uu > 0.0 ? clamp01(u.dot(place - a) / uu) : 0.0;
    const Eigen::Vector3d away = place - a - t * u;
    distance = away.norm();
    slope = distance > 0.0 ? Eigen::Vector3d(away / distance) : Eigen::Vector3d::Zero();
}

double pointSegmentDistance(const Eigen::Vector3d& point,
                            const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b)
{
    const Eigen::Vector3d u = b - a;
    const double uu = u.squaredNorm();
    const double t = uu > 0.0 ? clamp01(u.dot(point - a) / uu) : 0.0;
    return (point - a - t * u).norm();
}

bool contains(const Capsule& capsule, const Eigen::Vector3d& point)
{
    return pointSegmentDistance(point, capsule.a, capsule.b) <= capsule.radius_m;
}

double skinDistance(const std::vector<const Capsule*>& capsules, const Eigen::Vector3d& point)
{
    double least = INFINITY;
    for (const Capsule* capsule : capsules)
        least = std::min(least,
                         pointSegmentDistance(point, capsule->a, capsule->b) - capsule->radius_m);
    return least;
}

} // namespace midair::bridge
