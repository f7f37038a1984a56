#include "engine-bridge/hands/MeshDistance.h"

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/SegmentDistance.h"

#include <array>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr int kLeaf = 4; ///< triangles of a leaf, at most
/// Exceeds the rounding error of a bound, so that no triangle exactly at the limit is missed.
constexpr double kTreeSlack_m = 1e-12;
/// An order whose boxes have grown by more than this factor is computed again.
constexpr double kWorn = 2.0;

double areaOf(const haptics::TriangleMesh& mesh, int t)
{
    const Eigen::Vector3d p = mesh.vertices.col(mesh.triangles(0, t));
    const Eigen::Vector3d q = mesh.vertices.col(mesh.triangles(1, t));
    const Eigen::Vector3d r = mesh.vertices.col(mesh.triangles(2, t));
    return 0.5 * (q - p).cross(r - p).norm();
}

using Eigen::Vector3d;
using Near = std::vector<const Capsule*>;

/// Returns where the skin crosses the line from \a in (distance \a fIn < 0) to \a out (\a fOut >=
/// 0). The distance is convex, so false position converges from one side; three steps leave an
/// error of less than a hundredth of an edge.
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

/// True if one of \a clips cuts off the whole triangle; \a cut: one may cut a part.
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

/// A lower bound on the distance of the triangle from the capsule's axis, cheaper than the
/// distance: as that is convex, its tangent plane at the triangle's middle (AxisDistance).
double leastDistance(const Capsule& capsule, const SurfaceTriangle& t)
{
    const Vector3d middle = (t.p + t.q + t.r) / 3.0;
    const AxisDistance away(capsule.a, capsule.b, middle);
    return away.distance + std::min({away.slope.dot(t.p - middle),
                                     away.slope.dot(t.q - middle),
                                     away.slope.dot(t.r - middle)});
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
        // A capsule is convex: with three corners inside, the whole triangle is inside.
        if (!cut && contains(*capsule, t.p) && contains(*capsule, t.q) && contains(*capsule, t.r))
            return sum.add(t, n);
        if (leastDistance(*capsule, t) < capsule->radius_m) reaching.push_back(capsule);
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

bool isFinite(const haptics::TriangleMesh& mesh, int t)
{
    for (int k = 0; k < 3; ++k)
        if (!mesh.vertices.col(mesh.triangles(k, t)).allFinite()) return false;
    return true;
}

/// Computes an order: recursively splits the triangles at the median of their middles along the
/// longest side.
struct TriangleTree::Builder
{
    const haptics::TriangleMesh& mesh;
    Order order;
    Eigen::Matrix3Xd middles; ///< of the mesh's triangles

    explicit Builder(const haptics::TriangleMesh& itsMesh) : mesh(itsMesh)
    {
        order.ofTriangles = mesh.triangles.cols();
        middles.setZero(3, order.ofTriangles);
        for (Eigen::Index t = 0; t < order.ofTriangles; ++t)
        {
            const Eigen::Vector3i corners = mesh.triangles.col(t);
            if (corners.minCoeff() < 0 || corners.maxCoeff() >= mesh.vertices.cols()) continue;
            order.triangles.push_back(static_cast<int>(t));
            if (isFinite(mesh, static_cast<int>(t)))
                middles.col(t) = (mesh.vertices.col(corners[0]) + mesh.vertices.col(corners[1]) +
                                  mesh.vertices.col(corners[2])) /
                                 3.0;
        }
        order.links.reserve(order.triangles.size());
        if (!order.triangles.empty()) split(0, static_cast<int>(order.triangles.size()));
    }

    int longestSide(int first, int count) const
    {
        Eigen::AlignedBox3d box;
        for (int i = first; i < first + count; ++i)
            box.extend(middles.col(order.triangles[static_cast<std::size_t>(i)]));
        int side = 0;
        box.sizes().maxCoeff(&side);
        return side;
    }

    void split(int first, int count)
    {
        const std::size_t node = order.links.size();
        order.links.push_back({0, first, count});
        if (count <= kLeaf) return;
        const int side = longestSide(first, count);
        const auto begin = order.triangles.begin() + first;
        const int half = count / 2;
        // Ties are sorted by number, so that the same mesh gives the same order everywhere.
        std::nth_element(begin,
                         begin + half,
                         begin + count,
                         [&](int a, int b) {
                             return std::pair(middles(side, a), a) < std::pair(middles(side, b), b);
                         });
        split(first, half);
        order.links[node].right = static_cast<int>(order.links.size());
        split(first + half, count - half);
    }
};

TriangleTree::TriangleTree(const haptics::TriangleMesh& mesh, const TriangleTree* like) :
    _mesh(mesh)
{
    if (like && like->_order->ofTriangles == mesh.triangles.cols())
    {
        _order = like->_order;
        fit();
        if (_isEmpty || sizeOf() <= kWorn * _order->size_m) return;
    }
    Builder builder(mesh);
    auto order = std::make_shared<Order>(std::move(builder.order));
    _order = order;
    fit();
    order->size_m = sizeOf();
}

// Children have higher numbers than their parents.
void TriangleTree::fit()
{
    const std::vector<Link>& links = _order->links;
    _boxes.resize(links.size());
    for (std::size_t node = links.size(); node-- > 0;)
    {
        Box& box = _boxes[node];
        if (links[node].right == 0)
        {
            box = boxOf(links[node]);
            continue;
        }
        const Box& right = _boxes[static_cast<std::size_t>(links[node].right)];
        box = _boxes[node + 1]; // the left one
        box.extend(right);
        box.area += right.area;
    }
    _isEmpty = _boxes.empty() || _boxes.front().isEmpty();
}

TriangleTree::Box TriangleTree::boxOf(const Link& leaf) const
{
    Box box;
    for (int i = leaf.first; i < leaf.first + leaf.count; ++i)
    {
        const int t = _order->triangles[static_cast<std::size_t>(i)];
        if (!isFinite(_mesh, t)) continue;
        for (int k = 0; k < 3; ++k)
            box.extend(_mesh.vertices.col(_mesh.triangles(k, t)));
        box.area += areaOf(_mesh, t);
    }
    return box;
}

double TriangleTree::sizeOf() const
{
    double sum = 0.0;
    for (const Box& box : _boxes)
        if (!box.isEmpty()) sum += box.sizes().norm();
    return sum;
}

// A lower bound on the distance of the node's box from the axis, see AxisDistance. Infinite for a
// box without triangles.
double TriangleTree::lowerBound(const Capsule& capsule, int node) const
{
    const Box& box = _boxes[static_cast<std::size_t>(node)];
    if (box.isEmpty()) return INFINITY;
    const AxisDistance middle(capsule.a, capsule.b, box.center());
    return middle.distance - 0.5 * middle.slope.cwiseAbs().dot(box.sizes()) - kTreeSlack_m;
}

// Returns true only if the box is inside.
bool TriangleTree::isInside(int node, const Capsule& capsule) const
{
    const Box& box = _boxes[static_cast<std::size_t>(node)];
    return !box.isEmpty() &&
           pointSegmentDistance(box.center(), capsule.a, capsule.b) + 0.5 * box.sizes().norm() <=
               capsule.radius_m;
}

MeshDistance::MeshDistance(std::shared_ptr<const haptics::TriangleMesh> mesh,
                           const MeshDistance* like) :
    _mesh(std::move(mesh)),
    _tree(*_mesh, like ? &like->_tree : nullptr)
{
    if (_tree.isEmpty()) return;
    _centre = _tree.box().center();
    _radius_m = 0.5 * _tree.box().sizes().norm();
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
        // With a tolerance, so that no triangle exactly at the limit is skipped.
        if (leastDistance(capsule, {p, q, r}) > limit + kTreeSlack_m) return;
        const ClosestPair pair = closestSegmentTriangle(capsule.a, capsule.b, p, q, r);
        const double distance = pair.distance - capsule.radius_m;
        // Among triangles at the same distance takes the lowest index, so that the hierarchy's
        // order doesn't matter.
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
                                PatchMoments inside;
                                addInside({_mesh->vertices.col(corner[0]),
                                           _mesh->vertices.col(corner[1]),
                                           _mesh->vertices.col(corner[2])},
                                          Eigen::Vector3d::Zero(), // not used for the area
                                          near,
                                          {},
                                          resolution_m,
                                          inside);
                                return inside.area_m2;
                            });
}

} // namespace midair::bridge
