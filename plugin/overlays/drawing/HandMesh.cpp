#include "plugin/overlays/drawing/HandMesh.h"

#include "haptics/base/Units.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace osgMidair
{

namespace
{

using Eigen::Vector3d;
using Eigen::Vector3f;
using midair::bridge::Hand;
using midair::bridge::HAND_JOINTS;

constexpr double kCell_m = 3e-3;    ///< of the grid that the surface is found on
constexpr int kBlock = 4;           ///< cells along a block, which is skipped if it is off the skin
constexpr double kWidest_m = 10e-3; ///< of the blends between parts
constexpr double kJoint_m = 8e-3;   ///< from a joint on, along a bone, until the bone moves alone
constexpr double kKnuckle_m = 14e-3;  ///< the same from the knuckle into the palm
constexpr double kBackwards_m = 0.06; ///< how far into the palm a finger's chain is known
constexpr double kShared_m = 3e-3;    ///< between fingers
/// Rotations about y, towards the thumb: spread fingers have separate skin.
constexpr std::array<double, kHandChains> kSpread_deg = {8.0, 5.0, 1.0, -5.0, -12.0};

/// A ball swept from a to b with a changing radius.
struct Cone
{
    Vector3d a;
    Vector3d b;
    double from_m;
    double to_m;

    double distance(const Vector3d& at) const
    {
        const Vector3d way = b - a;
        const double t = std::clamp((at - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
        return (at - a - t * way).norm() - (from_m + t * (to_m - from_m));
    }
};

/// The shape of a hand: the palm and five fingers, each made of blended cones.
struct Parts
{
    std::array<std::vector<Cone>, 1 + kHandChains> groups; ///< the palm first
};

/// The smaller of two distances, with a blend of that width where they are equal.
double smaller(double a, double b, double width_m)
{
    const double near = std::max(width_m - std::abs(a - b), 0.0);
    return std::min(a, b) - 0.25 * near * near / width_m;
}

constexpr double kFar_m = 1.0;

double distanceTo(const Parts& parts, const Vector3d& at)
{
    const auto of = [&at](const std::vector<Cone>& cones, double width_m)
    {
        double d = kFar_m;
        for (const Cone& cone : cones)
            d = smaller(d, cone.distance(at), width_m);
        return d;
    };
    double fingers = kFar_m;
    for (std::size_t i = 1; i < parts.groups.size(); ++i)
        fingers = smaller(fingers, of(parts.groups[i], 3e-3), 1.5e-3);
    return smaller(of(parts.groups[0], kWidest_m), fingers, 6e-3);
}

/// Returns the \a parts whose skin may be within \a reach_m of \a at.
Parts near(const Parts& parts, const Vector3d& at, double reach_m)
{
    double least = kFar_m;
    for (const auto& group : parts.groups)
        for (const Cone& cone : group)
            least = std::min(least, cone.distance(at));
    Parts found;
    for (std::size_t i = 0; i < parts.groups.size(); ++i)
        for (const Cone& cone : parts.groups[i])
            if (cone.distance(at) <= least + 2.0 * reach_m + 1.5 * kWidest_m)
                found.groups[i].push_back(cone);
    return found;
}

void placeJoints(HandMesh& mesh)
{
    const Hand hand = midair::bridge::openHand(1, Eigen::Isometry3d::Identity());
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
    {
        mesh.joints[i] = hand.joints[i].position;
        mesh.radii_m[i] = hand.joints[i].radius_m;
    }
    for (int finger = 0; finger < kHandChains; ++finger)
    {
        const Vector3d knuckle = mesh.joints[static_cast<std::size_t>(chainJoint(finger, 0))];
        const Eigen::AngleAxisd turn(midair::base::toRadians(spreadAtRest_deg(finger)),
                                     Vector3d::UnitY());
        for (int k = 1; k <= kChainBones; ++k)
        {
            Vector3d& joint = mesh.joints[static_cast<std::size_t>(chainJoint(finger, k))];
            joint = knuckle + turn * (joint - knuckle);
        }
    }
}

Parts makeParts(const HandMesh& mesh)
{
    using namespace midair::bridge;
    const auto mm = [](double x, double y, double z)
    { return Vector3d(1e-3 * x, 1e-3 * y, 1e-3 * z); };
    Parts parts;
    std::vector<Cone>& palm = parts.groups[0];
    const auto bone = [&mesh](std::vector<Cone>& group, int from, int to, double less_m)
    {
        const auto a = static_cast<std::size_t>(from);
        const auto b = static_cast<std::size_t>(to);
        group.push_back(
            {mesh.joints[a], mesh.joints[b], mesh.radii_m[a] - less_m, mesh.radii_m[b] - less_m});
    };
    // Several cones blend in the palm, which thickens it.
    for (const int root : {INDEX_METACARPAL, MIDDLE_METACARPAL, RING_METACARPAL, LITTLE_METACARPAL})
        bone(palm, root, root + 1, 1.5e-3);
    for (const double x : {-11.0, 0.0, 11.0})
    {
        const double radius = x == 0.0 ? 1.5e-3 : 0.0; // more, in the middle
        palm.push_back({mm(0.7 * x, 0, 45), mm(x, 0, 74), 11e-3 + radius, 13.5e-3 + radius});
        palm.push_back({mm(x, 0, 74), mm(1.2 * x, 0, 114), 13.5e-3 + radius, 15.5e-3 + radius});
    }
    palm.push_back({mm(-13, -5, 55), mm(-36, -5, 30), 13e-3, 12e-3}); // the thumb's ball
    palm.push_back({mm(24, -5, 45), mm(30, -3, 0), 11e-3, 9e-3});     // the little finger's
    palm.push_back({mm(-38, -1, 22), mm(-27, -1, -14), 7e-3, 8e-3});  // the web
    for (int finger = 0; finger < kHandChains; ++finger)
        for (int k = 0; k < kChainBones; ++k)
            bone(parts.groups[static_cast<std::size_t>(finger) + 1],
                 chainJoint(finger, k),
                 chainJoint(finger, k + 1),
                 0.5e-3);
    return parts;
}

/// The surface of parts on a grid: a vertex in each cell that it crosses (surface nets).
class SkinFinder
{
public:
    SkinFinder(const Parts& parts, HandMesh& mesh) : _parts(parts), _mesh(mesh)
    {
        Eigen::AlignedBox3d box;
        for (const auto& group : parts.groups)
            for (const Cone& cone : group)
            {
                const Vector3d reach = Vector3d::Constant(std::max(cone.from_m, cone.to_m));
                for (const Vector3d& end : {cone.a, cone.b})
                    box.extend(Vector3d(end - reach)).extend(Vector3d(end + reach));
            }
        _low = box.min() - Vector3d::Constant(3.0 * kCell_m);
        for (int axis = 0; axis < 3; ++axis)
            _size[axis] =
                kBlock * (static_cast<int>(box.sizes()[axis] / kCell_m + 6.0) / kBlock + 1);
        const auto nodes = static_cast<std::size_t>(_size.prod());
        _values.assign(nodes, kFar_m);
        _vertexOf.assign(nodes, -1);
        _blocks.resize(nodes / (kBlock * kBlock * kBlock));
    }

    void find()
    {
        each(
            Eigen::Vector3i::Zero(), _size / kBlock, [this](const Eigen::Vector3i& b) { fill(b); });
        const Eigen::Vector3i cells = _size - Eigen::Vector3i::Ones();
        each(Eigen::Vector3i::Zero(), cells, [this](const Eigen::Vector3i& c) { addVertex(c); });
        each(Eigen::Vector3i::Ones(), cells, [this](const Eigen::Vector3i& c) { addFaces(c); });
    }

private:
    template<class F>
    static void each(const Eigen::Vector3i& from, const Eigen::Vector3i& to, const F& call)
    {
        Eigen::Vector3i at;
        for (at.z() = from.z(); at.z() < to.z(); ++at.z())
            for (at.y() = from.y(); at.y() < to.y(); ++at.y())
                for (at.x() = from.x(); at.x() < to.x(); ++at.x())
                    call(at);
    }
    static std::size_t index(const Eigen::Vector3i& at, const Eigen::Vector3i& size)
    {
        return static_cast<std::size_t>((at.z() * size.y() + at.y()) * size.x() + at.x());
    }
    std::size_t node(const Eigen::Vector3i& at) const { return index(at, _size); }
    Vector3d place(const Eigen::Vector3i& at) const { return _low + kCell_m * at.cast<double>(); }
    const Parts& partsAt(const Eigen::Vector3i& at) const
    {
        return _blocks[index(at / kBlock, _size / kBlock)];
    }

    /// For a block off the skin the signs suffice.
    void fill(const Eigen::Vector3i& block)
    {
        constexpr double kReach_m = kCell_m * (0.87 * kBlock + 1.0); // with a cell around it
        const Eigen::Vector3i first = kBlock * block;
        const Vector3d middle = place(first) + Vector3d::Constant(0.5 * kBlock * kCell_m);
        const double d = distanceTo(_parts, middle);
        Parts& parts = _blocks[index(block, _size / kBlock)];
        const bool isOff = std::abs(d) > kReach_m;
        if (!isOff) parts = near(_parts, middle, kReach_m);
        each(first,
             first + Eigen::Vector3i::Constant(kBlock),
             [&](const Eigen::Vector3i& at)
             { _values[node(at)] = isOff ? d : distanceTo(parts, place(at)); });
    }

    void addVertex(const Eigen::Vector3i& cell)
    {
        Vector3d sum = Vector3d::Zero();
        int crossings = 0;
        for (int corner = 0; corner < 8; ++corner)
            for (int axis = 0; axis < 3; ++axis)
            {
                if (corner >> axis & 1) continue;
                Eigen::Vector3i from =
                    cell + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2);
                Eigen::Vector3i to = from;
                ++to[axis];
                const double a = _values[node(from)];
                const double b = _values[node(to)];
                if ((a < 0.0) == (b < 0.0)) continue;
                sum += place(from) + a / (a - b) * (place(to) - place(from));
                ++crossings;
            }
        if (crossings == 0) return;
        _vertexOf[node(cell)] = static_cast<int>(_mesh.vertices.size());
        const Parts& parts = partsAt(cell);
        Vector3d at = sum / crossings;
        at -= distanceTo(parts, at) * slope(parts, at);
        _mesh.vertices.push_back(at.cast<float>());
        _mesh.normals.push_back(slope(parts, at).normalized().cast<float>());
    }

    static Vector3d slope(const Parts& parts, const Vector3d& at)
    {
        constexpr double kStep_m = 0.5e-3;
        Vector3d sum = Vector3d::Zero();
        for (const Vector3d& way :
             {Vector3d(1, -1, -1), Vector3d(-1, -1, 1), Vector3d(-1, 1, -1), Vector3d(1, 1, 1)})
            sum += way * distanceTo(parts, at + kStep_m * way);
        return sum / (4.0 * kStep_m);
    }

    /// Adds two triangles for each edge of the grid that the surface crosses, around it.
    void addFaces(const Eigen::Vector3i& at)
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            Eigen::Vector3i to = at;
            ++to[axis];
            const bool isInside = _values[node(at)] < 0.0;
            if (isInside == (_values[node(to)] < 0.0)) continue;
            Eigen::Vector3i u = Eigen::Vector3i::Zero();
            Eigen::Vector3i v = Eigen::Vector3i::Zero();
            u[(axis + 1) % 3] = 1;
            v[(axis + 2) % 3] = 1;
            std::array<unsigned int, 4> corners{};
            const std::array<Eigen::Vector3i, 4> cells = {at - u - v, at - v, at, at - u};
            for (std::size_t i = 0; i < 4; ++i)
                corners[i] = static_cast<unsigned int>(_vertexOf[node(cells[i])]);
            if (!isInside) std::swap(corners[1], corners[3]);
            for (const std::size_t i : {0, 1, 2, 0, 2, 3})
                _mesh.triangles.push_back(corners[i]);
        }
    }

    const Parts& _parts;
    HandMesh& _mesh;
    Vector3d _low;
    Eigen::Vector3i _size;
    std::vector<double> _values; ///< of the grid's nodes: distance, m
    std::vector<int> _vertexOf;  ///< of its cells; -1: none
    std::vector<Parts> _blocks;  ///< the parts near each of them
};

/// A position relative to a finger: along its chain, and its distance from the skin.
struct Beside
{
    double along_m = 0.0; ///< from the knuckle on; below 0: in the palm
    double away_m = 1.0;
};

Beside beside(const HandMesh& mesh, int finger, const Vector3d& at)
{
    Beside nearest;
    double begin_m = -kBackwards_m;
    for (int k = -1; k < kChainBones; ++k)
    {
        const auto i = static_cast<std::size_t>(chainJoint(finger, std::max(k, 0)));
        const auto j = static_cast<std::size_t>(chainJoint(finger, std::max(k, 0) + 1));
        const Vector3d way = (mesh.joints[j] - mesh.joints[i]).normalized();
        const double length_m = k < 0 ? kBackwards_m : (mesh.joints[j] - mesh.joints[i]).norm();
        const Vector3d a = k < 0 ? Vector3d(mesh.joints[i] - kBackwards_m * way) : mesh.joints[i];
        const double along_m = std::clamp((at - a).dot(way), 0.0, length_m);
        const double away_m = (at - a - along_m * way).norm() - mesh.radii_m[i];
        if (away_m < nearest.away_m) nearest = {begin_m + along_m, away_m};
        begin_m += length_m;
    }
    return nearest;
}

double eased(double t)
{
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

using Shares = std::array<double, kHandFrames>;

/// Adds the share \a weight of the frames of \a finger, \a along_m its chain.
void share(const HandMesh& mesh, int finger, double along_m, double weight, Shares& shares)
{
    int before = 0; // the palm's frame
    double begin_m = 0.0;
    double reach_m = kKnuckle_m;
    for (int k = 0; k < kChainBones; ++k)
    {
        const int joint = jointFrame(finger, k);
        const auto i = static_cast<std::size_t>(chainJoint(finger, k));
        const auto j = static_cast<std::size_t>(chainJoint(finger, k + 1));
        const double length_m = (mesh.joints[j] - mesh.joints[i]).norm();
        const double next_m = std::min(kJoint_m, 0.45 * length_m);
        if (along_m < begin_m)
        {
            const double s = eased((along_m - begin_m + reach_m) / reach_m);
            shares[static_cast<std::size_t>(before)] += weight * (1.0 - s);
            shares[static_cast<std::size_t>(joint)] += weight * s;
            return;
        }
        if (along_m < begin_m + length_m - next_m || k == kChainBones - 1)
        {
            const double s = eased((along_m - begin_m) / next_m);
            shares[static_cast<std::size_t>(joint)] += weight * (1.0 - s);
            shares[static_cast<std::size_t>(joint) + 1] += weight * s;
            return;
        }
        before = joint + 1;
        begin_m += length_m;
        reach_m = next_m;
    }
}

HandMesh::Skin strongest(const Shares& shares)
{
    std::array<std::size_t, kHandFrames> order{};
    std::iota(order.begin(), order.end(), 0U);
    std::partial_sort(order.begin(),
                      order.begin() + HandMesh::kInfluences,
                      order.end(),
                      [&shares](std::size_t a, std::size_t b) { return shares[a] > shares[b]; });
    HandMesh::Skin skin;
    double sum = 0.0;
    for (std::size_t i = 0; i < HandMesh::kInfluences; ++i)
        if (shares[order[i]] > 0.01) sum += shares[order[i]];
    for (std::size_t i = 0; i < HandMesh::kInfluences && shares[order[i]] > 0.01; ++i)
    {
        skin.frames[i] = static_cast<unsigned char>(order[i]);
        skin.shares[i] = static_cast<float>(shares[order[i]] / sum);
        ++skin.count;
    }
    return skin;
}

void addSkin(HandMesh& mesh)
{
    Hand hand;
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
    {
        hand.joints[i].position = mesh.joints[i];
        hand.joints[i].radius_m = mesh.radii_m[i];
        hand.joints[i].positionValid = true;
    }
    midair::bridge::HandFrame frame;
    frame.hands = {hand};
    const std::vector<midair::bridge::HandCapsule> bones = midair::bridge::handCapsules(frame);
    for (const Vector3f& vertex : mesh.vertices)
    {
        const Vector3d at = vertex.cast<double>();
        std::array<Beside, kHandChains> fingers;
        double least_m = kFar_m;
        for (int finger = 0; finger < kHandChains; ++finger)
        {
            fingers[static_cast<std::size_t>(finger)] = beside(mesh, finger, at);
            least_m = std::min(least_m, fingers[static_cast<std::size_t>(finger)].away_m);
        }
        Shares shares{};
        for (int finger = 0; finger < kHandChains; ++finger)
        {
            const Beside& one = fingers[static_cast<std::size_t>(finger)];
            const double x = (one.away_m - least_m) / kShared_m;
            share(mesh, finger, one.along_m, std::exp(-0.5 * x * x), shares);
        }
        HandMesh::Skin skin = strongest(shares);
        double nearest_m = kFar_m;
        for (const midair::bridge::HandCapsule& bone : bones)
        {
            const Cone cone = {
                bone.shape.a, bone.shape.b, bone.shape.radius_m, bone.shape.radius_m};
            const double d = cone.distance(at);
            if (d >= nearest_m) continue;
            nearest_m = d;
            skin.bone = static_cast<unsigned char>(bone.bone);
        }
        mesh.skin.push_back(skin);
    }
}

HandMesh makeHand()
{
    HandMesh mesh;
    placeJoints(mesh);
    const Parts parts = makeParts(mesh);
    SkinFinder(parts, mesh).find();
    addSkin(mesh);
    return mesh;
}

} // namespace

double spreadAtRest_deg(int finger)
{
    return kSpread_deg[static_cast<std::size_t>(finger)];
}

int chainJoint(int finger, int k)
{
    return (finger == midair::bridge::THUMB
                ? midair::bridge::THUMB_METACARPAL
                : midair::bridge::INDEX_PROXIMAL + 5 * (finger - midair::bridge::INDEX)) +
           k;
}

const HandMesh& handMesh()
{
    static const HandMesh mesh = makeHand();
    return mesh;
}

} // namespace osgMidair
