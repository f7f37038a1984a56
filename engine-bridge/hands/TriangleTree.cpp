#include "engine-bridge/hands/TriangleTree.h"

#include "engine-bridge/hands/SegmentDistance.h"

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

} // namespace midair::bridge
