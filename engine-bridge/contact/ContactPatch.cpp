#include "engine-bridge/contact/ContactPatch.h"

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/SmallMatrices.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;
using Near = std::vector<const Capsule*>;

/// False only if all of the triangle is outside: the distance from the axis is convex, so it is at
/// least its tangent plane at the middle (AxisDistance).
bool mayReach(const Capsule& capsule, const SurfaceTriangle& t)
{
    const Vector3d middle = (t.p + t.q + t.r) / 3.0;
    const AxisDistance away(capsule.a, capsule.b, middle);
    const double nearest = std::min(
        {away.slope.dot(t.p - middle), away.slope.dot(t.q - middle), away.slope.dot(t.r - middle)});
    return away.distance + nearest < capsule.radius_m;
}

/// Where the skin crosses the line from \a in (distance \a fIn < 0) to \a out (\a fOut >= 0). The
/// distance is convex, so false position comes to the place from one side; three steps leave less
/// than a hundredth of an edge.
Vector3d crossing(const Near& capsules, Vector3d in, double fIn, const Vector3d& out, double fOut)
{
    Vector3d place = in;
    for (int step = 0; step < 3; ++step)
    {
        place = in + fIn / (fIn - fOut) * (out - in);
        const double f = skinDistance(capsules, place);
        if (!(f < 0.0)) break;
        in = place;
        fIn = f;
    }
    return place;
}

void addCut(const SurfaceTriangle& t, const Vector3d& n, const Near& capsules, PatchMoments& sum)
{
    const std::array<Vector3d, 3> corner = {t.p, t.q, t.r};
    const std::array<double, 3> f = {
        skinDistance(capsules, t.p), skinDistance(capsules, t.q), skinDistance(capsules, t.r)};
    const auto in = std::count_if(f.begin(), f.end(), [](double value) { return value < 0.0; });
    if (in == 0) return;
    if (in == 3) return sum.add(t, n);
    std::size_t alone = 0;
    while ((f[alone] < 0.0) != (in == 1))
        ++alone;
    const std::size_t next = (alone + 1) % 3, last = (alone + 2) % 3;
    const auto cut = [&](std::size_t other)
    {
        return f[alone] < 0.0
                   ? crossing(capsules, corner[alone], f[alone], corner[other], f[other])
                   : crossing(capsules, corner[other], f[other], corner[alone], f[alone]);
    };
    const Vector3d toNext = cut(next), toLast = cut(last);
    if (in == 1) return sum.add({corner[alone], toNext, toLast}, n);
    sum.add({toNext, corner[next], corner[last]}, n);
    sum.add({toNext, corner[last], toLast}, n);
}

/// True if one of \a clips cuts all of the triangle off; \a cut: one may cut a part.
bool isClippedAway(const SurfaceTriangle& t, const std::vector<Eigen::Vector4d>& clips, bool& cut)
{
    for (const Eigen::Vector4d& clip : clips)
    {
        const auto isOff = [&](const Vector3d& x) { return clip.head<3>().dot(x) + clip[3] < 0.0; };
        const int off = int(isOff(t.p)) + int(isOff(t.q)) + int(isOff(t.r));
        if (off == 3) return true;
        cut = cut || off > 0;
    }
    return false;
}

using Eigen::Vector3d;

constexpr double kFarOut_m = 1.0; ///< farther along a line than any hand reaches
/// Share of the radius beside the axis up to which the skin is used: farther out it is so steep
/// that small steps across are long ones on it, and it faces away from the object.
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

/// Of the line x + t u, u of unit length: its ends are on one of the balls or on the side between.
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

void PatchMoments::add(const SurfaceTriangle& t, const Vector3d& n)
{
    const double area = 0.5 * (t.q - t.p).cross(t.r - t.p).norm();
    const Vector3d s = t.p + t.q + t.r;
    area_m2 += area;
    first += area / 3.0 * s;
    second +=
        area / 12.0 *
        (t.p * t.p.transpose() + t.q * t.q.transpose() + t.r * t.r.transpose() + s * s.transpose());
    normal += area * n;
    normals += area * n * n.transpose();
}

void PatchMoments::add(const PatchMoments& other)
{
    area_m2 += other.area_m2;
    first += other.first;
    second += other.second;
    normal += other.normal;
    normals += other.normals;
}

Eigen::Matrix3d PatchMoments::covariance() const
{
    const Vector3d mean = centre();
    return second / area_m2 - mean * mean.transpose();
}

void addInside(const SurfaceTriangle& t,
               const Vector3d& n,
               const Near& capsules,
               const std::vector<Eigen::Vector4d>& clips,
               double resolution_m,
               PatchMoments& sum)
{
    bool cut = false;
    if (isClippedAway(t, clips, cut)) return;
    const double pq = (t.p - t.q).squaredNorm();
    const double qr = (t.q - t.r).squaredNorm();
    const double rp = (t.r - t.p).squaredNorm();
    const double longest = std::max({pq, qr, rp});
    if (longest <= resolution_m * resolution_m)
    {
        if (!cut || !isClipped(clips, (t.p + t.q + t.r) / 3.0)) addCut(t, n, capsules, sum);
        return;
    }
    Near reaching;
    for (const Capsule* capsule : capsules)
    {
        // A capsule is convex: with three corners inside, the whole triangle is.
        if (!cut && contains(*capsule, t.p) && contains(*capsule, t.q) && contains(*capsule, t.r))
            return sum.add(t, n);
        if (mayReach(*capsule, t)) reaching.push_back(capsule);
    }
    if (reaching.empty()) return;
    // Halves the longest edge, so that thin triangles become compact.
    SurfaceTriangle turned = t;
    if (qr == longest)
        turned = {t.q, t.r, t.p};
    else if (rp == longest)
        turned = {t.r, t.p, t.q};
    const Vector3d middle = 0.5 * (turned.p + turned.q);
    addInside({turned.p, middle, turned.r}, n, reaching, clips, resolution_m, sum);
    addInside({middle, turned.q, turned.r}, n, reaching, clips, resolution_m, sum);
}

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
    // Goes on where the next bone begins before this one ends.
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
