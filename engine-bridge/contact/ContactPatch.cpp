#include "engine-bridge/contact/ContactPatch.h"

#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/SmallMatrices.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kFarOut_m = 1.0; ///< farther along a line than any hand reaches
/// Share of the radius beside the axis up to which the skin is used: farther out it is so steep
/// that small lateral steps are long ones on it, and it faces away from the object.
constexpr double kUsable = 0.8;
constexpr double kLineSlack_m = 1e-9;

/// The part of a line inside a capsule; empty (from > to) if there is none.
struct Inside
{
    double from = INFINITY;
    double to = -INFINITY;

    void take(double t)
    {
        from = std::min(from, t);
        to = std::max(to, t);
    }
};

void takeBall(Inside& inside, const Vector3d& x, const Vector3d& u, const Vector3d& c, double r)
{
    const double along = (c - x).dot(u);
    const double rest = r * r - (c - x).squaredNorm() + along * along;
    if (rest < 0.0) return;
    inside.take(along - std::sqrt(rest));
    inside.take(along + std::sqrt(rest));
}

/// Part of the line x + t u, u of unit length: its ends are on one of the spheres or on the
/// cylinder.
Inside insideOf(const Capsule& capsule, const Vector3d& x, const Vector3d& u)
{
    Inside inside;
    takeBall(inside, x, u, capsule.a, capsule.radius_m);
    takeBall(inside, x, u, capsule.b, capsule.radius_m);
    const Vector3d axis = capsule.b - capsule.a;
    const double length = axis.norm();
    if (!(length > 0.0)) return inside;
    const Vector3d w = axis / length;
    const Vector3d across = u - u.dot(w) * w;
    const Vector3d start = x - capsule.a - (x - capsule.a).dot(w) * w;
    const double uu = across.squaredNorm();
    if (!(uu > 1e-12)) return inside;
    const double ux = across.dot(start);
    const double root = ux * ux - uu * (start.squaredNorm() - capsule.radius_m * capsule.radius_m);
    if (root < 0.0) return inside;
    for (const double t : {(-ux - std::sqrt(root)) / uu, (-ux + std::sqrt(root)) / uu})
    {
        const double along = (x + t * u - capsule.a).dot(w);
        if (along >= 0.0 && along <= length) inside.take(t);
    }
    return inside;
}

} // namespace

void setShape(ContactPatch& patch, const PatchMoments& moments, const Vector3d& normal)
{
    patch.area_m2 = moments.area_m2;
    patch.centre = moments.centre();
    patch.covariance = moments.covariance();
    patch.normal = normal;
    const Vector3d u = normal.unitOrthogonal();
    const Vector3d v = normal.cross(u);
    Eigen::Matrix<double, 3, 2> plane;
    plane << u, v;
    const base::SymmetricAxes<2> axes =
        base::symmetricAxes(Eigen::Matrix2d(plane.transpose() * patch.covariance * plane));
    const Eigen::Vector2d values = axes.values.cwiseMax(0.0); // ascending
    patch.semiMinor_m = 2.0 * std::sqrt(values[0]);
    patch.semiMajor_m = 2.0 * std::sqrt(values[1]);
    patch.major = (plane * axes.vectors.col(1)).normalized();
    patch.minor = normal.cross(patch.major);
}

double depthIn(const Capsule& capsule, const Vector3d& place, const Vector3d& normal)
{
    const Inside inside = insideOf(capsule, place, -normal);
    return inside.from <= inside.to ? inside.to : NAN;
}

Vector3d skinUnder(const ContactPatch& patch, const Vector3d& place)
{
    const Vector3d u = -patch.normal;
    const Capsule* nearest = nullptr;
    ClosestPair pair;
    double least = INFINITY; // distance of the line from the axis, in radii
    for (const Capsule& capsule : patch.own)
    {
        const ClosestPair one =
            closestSegments(place - kFarOut_m * u, place + kFarOut_m * u, capsule.a, capsule.b);
        if (!(one.distance / capsule.radius_m < least)) continue;
        least = one.distance / capsule.radius_m;
        nearest = &capsule;
        pair = one;
    }
    if (!nearest) return place;
    Vector3d x = place;
    if (least > kUsable) x += (1.0 - kUsable / least) * (pair.onOther - pair.onSegment);
    double end = insideOf(*nearest, x, u).to;
    if (!std::isfinite(end)) return place;
    // Continues with the next bone where this one ends.
    const std::vector<Capsule>& skin = patch.skin ? *patch.skin : patch.own;
    for (std::size_t pass = 0; pass < skin.size(); ++pass)
    {
        const double before = end;
        for (const Capsule& capsule : skin)
        {
            const Inside inside = insideOf(capsule, x, u);
            if (inside.from <= end + kLineSlack_m) end = std::max(end, inside.to);
        }
        if (!(end > before)) break;
    }
    return x + end * u;
}

} // namespace midair::bridge
