#include "engine-bridge/hands/MeshDistance.h"

#include "engine-bridge/hands/SegmentDistance.h"

#include <array>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr int kLeaf = 4; ///< triangles of a leaf, at most
/// Above the rounding of a bound, so that no triangle at exactly the limit is missed.
constexpr double kTreeSlack_m = 1e-12;
/// An order whose boxes have become larger than this many times is found anew.
constexpr double kWorn = 2.0;

double areaOf(const haptics::TriangleMesh& mesh, int t)
{
    const Eigen::Vector3d p = mesh.vertices.col(mesh.triangles(0, t));
    const Eigen::Vector3d q = mesh.vertices.col(mesh.triangles(1, t));
    const Eigen::Vector3d r = mesh.vertices.col(mesh.triangles(2, t));
    return 0.5 * (q - p).cross(r - p).norm();
}

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

bool isFinite(const haptics::TriangleMesh& mesh, int t)
{
    for (int k = 0; k < 3; ++k)
        if (!mesh.vertices.col(mesh.triangles(k, t)).allFinite()) return false;
    return true;
}

/// Finds an order: halves the triangles at the median of their middles along the longest side of
/// these, again and again.
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
        Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY);
        Eigen::Vector3d high = -low;
        for (int i = first; i < first + count; ++i)
        {
            const auto middle = middles.col(order.triangles[static_cast<std::size_t>(i)]);
            low = low.cwiseMin(middle);
            high = high.cwiseMax(middle);
        }
        int side = 0;
        (high - low).maxCoeff(&side);
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
        // By number where they are level, so that the same mesh gives the same order everywhere.
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
            fitLeaf(links[node], box);
            continue;
        }
        const Box& left = _boxes[node + 1];
        const Box& right = _boxes[static_cast<std::size_t>(links[node].right)];
        box = {
            left.low.cwiseMin(right.low), left.high.cwiseMax(right.high), left.area + right.area};
    }
    _isEmpty = _boxes.empty() || !_boxes.front().low.allFinite();
}

void TriangleTree::fitLeaf(const Link& link, Box& box) const
{
    box.low.setConstant(INFINITY);
    box.high.setConstant(-INFINITY);
    box.area = 0.0;
    for (int i = link.first; i < link.first + link.count; ++i)
    {
        const int t = _order->triangles[static_cast<std::size_t>(i)];
        if (!isFinite(_mesh, t)) continue;
        for (int k = 0; k < 3; ++k)
        {
            const auto corner = _mesh.vertices.col(_mesh.triangles(k, t));
            box.low = box.low.cwiseMin(corner);
            box.high = box.high.cwiseMax(corner);
        }
        box.area += areaOf(_mesh, t);
    }
}

double TriangleTree::sizeOf() const
{
    double sum = 0.0;
    for (const Box& box : _boxes)
        if (box.low.x() <= box.high.x()) sum += (box.high - box.low).norm();
    return sum;
}

// A lower bound on the distance of the node's box from the axis, see AxisDistance. Infinite for a
// box without triangles.
double TriangleTree::lowerBound(const Capsule& capsule, int node) const
{
    const Box& box = _boxes[static_cast<std::size_t>(node)];
    if (!(box.low.x() <= box.high.x())) return INFINITY;
    const AxisDistance middle(capsule.a, capsule.b, 0.5 * (box.low + box.high));
    return middle.distance - 0.5 * middle.slope.cwiseAbs().dot(box.high - box.low) - kTreeSlack_m;
}

// Never true of a box that is not inside.
bool TriangleTree::isInside(int node, const Capsule& capsule) const
{
    const Box& box = _boxes[static_cast<std::size_t>(node)];
    if (!(box.low.x() <= box.high.x())) return false;
    return pointSegmentDistance(0.5 * (box.low + box.high), capsule.a, capsule.b) +
               0.5 * (box.high - box.low).norm() <=
           capsule.radius_m;
}

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
