#include "engine-bridge/contact/ContactFinder.h"

#include "engine-bridge/hands/PressedSkin.h"
#include "engine-bridge/hands/SegmentDistance.h"
#include "haptics/base/InputError.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/text/Range.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace midair::bridge
{

namespace
{

using Place = std::array<double, 3>;

constexpr double kSame_m = 1e-9; ///< places that round to the same multiples count as one

/// Numbers the vertices by place, so that duplicates at seams get one number.
std::vector<int> welded(const Eigen::Matrix3Xd& vertices)
{
    std::vector<int> order(static_cast<std::size_t>(vertices.cols()));
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = static_cast<int>(i);
    const auto rounded = [&](int axis, int v) { return std::round(vertices(axis, v) / kSame_m); };
    const auto place = [&](int v) { return Place{rounded(0, v), rounded(1, v), rounded(2, v)}; };
    const auto isFinite = [&](int v) { return vertices.col(v).allFinite(); };
    order.erase(std::partition(order.begin(), order.end(), isFinite), order.end());
    std::sort(order.begin(), order.end(), [&](int a, int b) { return place(a) < place(b); });
    std::vector<int> weld(static_cast<std::size_t>(vertices.cols()), -1);
    int last = -1;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        if (i == 0 || place(order[i]) != place(order[i - 1])) last = order[i];
        weld[static_cast<std::size_t>(order[i])] = last;
    }
    return weld;
}

using Eigen::Vector3d;

constexpr double kOneSided = 0.5; ///< share of the area that the mean normal keeps; below: split
constexpr double kLeastArea_m2 = 1e-12; ///< a square of a micrometre; smaller areas count as none
constexpr std::uint64_t kWindingsKept = 600; ///< updates

bool isFinite(const Eigen::Isometry3d& pose)
{
    return pose.matrix().allFinite();
}

/// Height of the bone's axis over the outer side of a part of the surface, m.
double heightOfAxis(const ContactPatch& patch, const Vector3d& normal)
{
    const Capsule& bone = patch.own.front();
    const ClosestPair pair = closestSegments(patch.centre, patch.centre, bone.a, bone.b);
    return normal.dot(pair.onOther - patch.centre);
}

/// Patches whose normals differ by more than this angle aren't joined, whatever their distance.
constexpr double kSameWay = 0.5; // 60 degrees

bool overlap(const Capsule& a, const Capsule& b)
{
    return closestSegments(a.a, a.b, b.a, b.b).distance < a.radius_m + b.radius_m;
}

} // namespace

int windingOf(const haptics::TriangleMesh& mesh)
{
    const std::vector<int> weld = welded(mesh.vertices);
    std::vector<std::pair<int, int>> edges; // as the triangles go round
    double volume = 0.0;                    // six times
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        const Eigen::Vector3i index = mesh.triangles.col(t);
        if (index.minCoeff() < 0 || index.maxCoeff() >= mesh.vertices.cols()) continue;
        std::array<int, 3> corner{};
        for (int k = 0; k < 3; ++k)
            corner[static_cast<std::size_t>(k)] = weld[static_cast<std::size_t>(index[k])];
        const bool isFlat = corner[0] == corner[1] || corner[1] == corner[2] ||
                            corner[2] == corner[0] ||
                            *std::min_element(corner.begin(), corner.end()) < 0;
        if (isFlat) continue;
        for (std::size_t k = 0; k < 3; ++k)
            edges.emplace_back(corner[k], corner[(k + 1) % 3]);
        const Eigen::Vector3d base = mesh.vertices.col(corner[0]);
        volume += base.dot(Eigen::Vector3d(mesh.vertices.col(corner[1]))
                               .cross(Eigen::Vector3d(mesh.vertices.col(corner[2]))));
    }
    if (edges.empty()) return 0;
    std::sort(edges.begin(), edges.end());
    if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return 0;
    for (const auto& [from, to] : edges)
        if (!std::binary_search(edges.begin(), edges.end(), std::pair(to, from))) return 0;
    return volume > 0.0 ? 1 : volume < 0.0 ? -1 : 0;
}

const char* contactReasonText(ContactReason reason)
{
    switch (reason)
    {
    case ContactReason::NONE:
        return "";
    case ContactReason::TIME_NOT_FINITE:
        return "the time isn't a finite number, or it runs backwards";
    case ContactReason::JOINT_NOT_FINITE:
        return "a joint that counts as tracked has a place that isn't a finite number";
    case ContactReason::RADIUS_OUT_OF_RANGE:
        return "a joint's radius isn't above 0 and at most 100 mm";
    case ContactReason::POSE_NOT_FINITE:
        return "the pose of the object isn't made of finite numbers";
    case ContactReason::MESH_NOT_READY:
        return "the object's mesh is still being prepared";
    case ContactReason::NO_AREA:
        return "the touched part has no area";
    case ContactReason::MATERIAL_INVALID:
        return "a number of the object's material is out of range; it is silent where it is "
               "touched";
    case ContactReason::HAND_JUMPED:
        return "the hand jumped; its contact starts again";
    }
    return "";
}

bool ContactFinderOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ContactFinderOptions: ")
        .within("resolution_m", resolution_m, 1e-4, 1e-2)
        .within("join_m", join_m, 0.0, 0.1)
        .within("part_m", part_m, join_m, 0.1)
        .within("leave_m", leave_m, 0.0, 0.1)
        .passed(error);
}

ContactFinder::ContactFinder(const ContactFinderOptions& options) : _options(options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
}

// Reports capsules that handCapsules() left out because of a wrong number, but not untracked ones.
std::vector<HandCapsule> ContactFinder::usableCapsules(const HandFrame& hands)
{
    for (const Hand& hand : hands.hands)
        for (const HandJoint& joint : hand.joints)
        {
            if (!joint.positionValid) continue;
            if (!joint.position.allFinite())
                _notes.push_back({ContactReason::JOINT_NOT_FINITE, hand.id, -1, 0});
            else if (!(joint.radius_m > 0.0 && joint.radius_m <= kMostRadius_m))
                _notes.push_back({ContactReason::RADIUS_OUT_OF_RANGE, hand.id, -1, 0});
        }
    std::vector<HandCapsule> capsules = handCapsules(hands);
    capsules.erase(std::remove_if(capsules.begin(),
                                  capsules.end(),
                                  [](const HandCapsule& capsule)
                                  { return !(capsule.shape.radius_m <= kMostRadius_m); }),
                   capsules.end());
    return capsules;
}

int ContactFinder::windingOfMesh(const HapticObject& object, const haptics::TriangleMesh& mesh)
{
    const std::uint64_t key = object.topologyId ? object.topologyId : object.meshId;
    const auto found = _windings.find(key);
    if (found == _windings.end()) return (_windings[key] = {windingOf(mesh), _updates}).sign;
    found->second.lastUse = _updates;
    return found->second.sign;
}

void ContactFinder::update(const std::vector<HapticObject>& objects, const HandFrame& hands)
{
    ++_updates;
    _notes.clear();
    _nearby.clear();
    _parts.clear();
    _patches.clear();
    const std::vector<HandCapsule> capsules = usableCapsules(hands);
    _presses = hands.presses;
    _meshes.beginUpdate();
    for (const HapticObject& object : objects)
    {
        if (capsules.empty()) break;
        if (!object.mesh) continue;
        if (!isFinite(object.pose))
        {
            _notes.push_back({ContactReason::POSE_NOT_FINITE, 0, -1, object.touchId()});
            continue;
        }
        const std::shared_ptr<const MeshDistance> mesh = _meshes.get(object);
        if (!mesh)
        {
            _notes.push_back({ContactReason::MESH_NOT_READY, 0, -1, object.touchId()});
            continue;
        }
        const Vector3d centre = object.pose * mesh->centre();
        for (const HandCapsule& capsule : capsules)
        {
            const double gap = pointSegmentDistance(centre, capsule.shape.a, capsule.shape.b) -
                               capsule.shape.radius_m - mesh->radius_m();
            if (gap <= _options.leave_m) touch(object, mesh, capsule);
        }
    }
    _meshes.endUpdate();
    for (auto entry = _windings.begin(); entry != _windings.end();)
        entry = entry->second.lastUse + kWindingsKept < _updates ? _windings.erase(entry)
                                                                 : std::next(entry);
    join();
    std::unordered_map<int, std::shared_ptr<const std::vector<Capsule>>> skins;
    for (ContactPatch& patch : _patches)
    {
        auto& skin = skins[patch.hand];
        if (!skin)
        {
            auto all = std::make_shared<std::vector<Capsule>>();
            for (const HandCapsule& capsule : capsules)
                if (capsule.hand == patch.hand) all->push_back(capsule.shape);
            skin = std::move(all);
        }
        patch.skin = skin;
    }
}

void ContactFinder::touch(const HapticObject& object,
                          const std::shared_ptr<const MeshDistance>& mesh,
                          HandCapsule capsule)
{
    const Eigen::Isometry3d toMesh = object.pose.inverse();
    const NearestSpot spot = mesh->nearest(moved(capsule.shape, toMesh), _options.leave_m);
    if (spot.triangle < 0) return;
    const std::optional<double> depth_m =
        pressedDepth_m(_presses, capsule.hand, capsule.bone, *mesh, toMesh);
    const double out_m = depth_m ? pressedOut_m(spot.distance_m, *depth_m) : 0.0;
    capsule.shape.radius_m += out_m;
    if (spot.distance_m - out_m >= 0.0)
    {
        if (!isClipped(object.clips, object.pose * spot.onSurface))
            _nearby.push_back({object.touchId(), capsule.hand, capsule.bone, spot.distance_m});
        return;
    }
    Part part;
    part.patch.object = object.touchId();
    part.patch.hand = capsule.hand;
    part.patch.bones = {capsule.bone};
    part.patch.own = {capsule.shape};
    part.patch.objectPose = object.pose;
    part.mesh = mesh;
    part.patch.surface = mesh;
    part.piece = &object;
    part.winding = windingOfMesh(object, mesh->mesh());
    PatchMoments all;
    std::vector<PatchMoments> sides; // of each triangle
    addSurface(part, {&capsule.shape}, all, &sides);
    if (all.area_m2 > kLeastArea_m2 && all.normal.allFinite() && all.second.allFinite())
        addParts(std::move(part), all, sides);
    else
        _notes.push_back({ContactReason::NO_AREA, capsule.hand, capsule.bone, object.touchId()});
}

void ContactFinder::addSurface(const Part& part,
                               const std::vector<const Capsule*>& capsules,
                               PatchMoments& all,
                               std::vector<PatchMoments>* ofTriangles) const
{
    const haptics::TriangleMesh& mesh = part.mesh->mesh();
    const Eigen::Isometry3d& pose = part.piece->pose;
    std::vector<int> triangles;
    for (const Capsule* capsule : capsules)
        part.mesh->tree().walk(moved(*capsule, pose.inverse()),
                               capsule->radius_m,
                               [&](int t) { triangles.push_back(t); });
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    for (const int t : triangles)
    {
        if (!bridge::isFinite(mesh, t)) continue;
        const Eigen::Vector3i corner = mesh.triangles.col(t);
        const SurfaceTriangle triangle = {pose * mesh.vertices.col(corner[0]),
                                          pose * mesh.vertices.col(corner[1]),
                                          pose * mesh.vertices.col(corner[2])};
        Vector3d n = (triangle.q - triangle.p).cross(triangle.r - triangle.p);
        const double size = n.norm();
        if (!(size > 0.0) || !std::isfinite(size)) continue;
        n *= (part.winding < 0 ? -1.0 : 1.0) / size;
        if (part.isSplit && n.dot(part.patch.normal) * part.windingSide <= 0.0) continue;
        PatchMoments one;
        addInside(triangle, n, capsules, part.piece->clips, _options.resolution_m, one);
        if (!(one.area_m2 > 0.0)) continue;
        all.add(one);
        if (ofTriangles) ofTriangles->push_back(one);
    }
}

Vector3d ContactFinder::orient(const Part& part, const Vector3d& normal) const
{
    if (part.winding != 0) return normal;
    const Key key = keyOf(part);
    for (const auto& [other, before] : _normals)
        if (other == key) return before.dot(normal) < 0.0 ? Vector3d(-normal) : normal;
    return heightOfAxis(part.patch, normal) < 0.0 ? Vector3d(-normal) : normal;
}

ContactFinder::Key ContactFinder::keyOf(const Part& part)
{
    const ContactPatch& patch = part.patch;
    return {part.piece->id,
            static_cast<std::uint64_t>(static_cast<std::uint32_t>(patch.hand)),
            static_cast<std::uint64_t>(2 * patch.bones.front() + part.side)};
}

void ContactFinder::addParts(Part part,
                             const PatchMoments& all,
                             const std::vector<PatchMoments>& sides)
{
    const auto add = [&](Part one, const PatchMoments& moments)
    {
        if (!(moments.area_m2 > kLeastArea_m2)) return;
        Vector3d normal = moments.normal;
        // A sheet with randomly wound triangles has no mean normal; their common axis is used.
        if (!(normal.norm() > 1e-9 * moments.area_m2))
            normal = base::symmetricAxes(moments.normals).vectors.col(2);
        normal.normalize();
        setShape(one.patch, moments, normal);
        const Vector3d outward = orient(one, normal);
        one.windingSide = outward.dot(normal) < 0.0 ? -1.0 : 1.0;
        setShape(one.patch, moments, outward);
        one.moments = moments;
        const double depth = depthIn(one.patch.own.front(), one.patch.centre, outward);
        one.patch.depth_m = depth > 0.0 ? depth : 0.0;
        _parts.push_back(std::move(one));
    };
    if (all.normal.norm() >= kOneSided * all.area_m2) return add(std::move(part), all);
    const Vector3d axis = base::symmetricAxes(all.normals).vectors.col(2);
    std::array<PatchMoments, 2> half;
    for (const PatchMoments& one : sides)
        half[one.normal.dot(axis) >= 0.0 ? 0 : 1].add(one);
    part.isSplit = true;
    const std::size_t first = _parts.size();
    add(part, half[0]);
    part.side = 1;
    add(part, half[1]);
    if (_parts.size() != first + 2) return;
    ContactPatch& a = _parts[first].patch;
    ContactPatch& b = _parts[first + 1].patch;
    if (a.normal.dot(b.normal) >= 0.0) return;
    const double aboveA = heightOfAxis(a, a.normal);
    const double aboveB = heightOfAxis(b, b.normal);
    if (std::min(aboveA, aboveB) < 0.0) (aboveA < aboveB ? a : b).isExit = true;
}

// Sums over the union of the overlapping parts, so that no part of the surface counts twice.
ContactPatch ContactFinder::joined(const std::vector<const Part*>& members) const
{
    ContactPatch patch = members.front()->patch;
    if (members.size() == 1) return patch;
    patch.bones.clear();
    patch.own.clear();
    patch.depth_m = 0.0;
    patch.isExit = true;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    std::vector<const Capsule*> capsules;
    bool isOverlapping = false;
    for (const Part* member : members)
    {
        const ContactPatch& one = member->patch;
        const Capsule& shape = one.own.front();
        normal += one.area_m2 * one.normal;
        patch.depth_m = std::max(patch.depth_m, one.depth_m);
        patch.isExit = patch.isExit && one.isExit;
        const int bone = one.bones.front();
        if (std::find(patch.bones.begin(), patch.bones.end(), bone) != patch.bones.end()) continue;
        for (const Capsule* other : capsules)
            isOverlapping = isOverlapping || overlap(*other, shape);
        capsules.push_back(&shape);
        patch.bones.push_back(bone);
        patch.own.push_back(shape);
    }
    std::sort(patch.bones.begin(), patch.bones.end());
    PatchMoments sum;
    std::vector<const HapticObject*> done;
    for (const Part* member : members)
        if (!isOverlapping)
            sum.add(member->moments);
        else if (std::find(done.begin(), done.end(), member->piece) == done.end())
        {
            done.push_back(member->piece);
            addSurface(*member, capsules, sum, nullptr);
        }
    setShape(patch, sum, normal.normalized());
    return patch;
}

void ContactFinder::join()
{
    const std::size_t count = _parts.size();
    std::vector<std::size_t> group(count);
    std::iota(group.begin(), group.end(), std::size_t(0));
    std::vector<std::pair<Key, Key>> pairs;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
        {
            const ContactPatch &a = _parts[i].patch, &b = _parts[j].patch;
            if (a.hand != b.hand || a.object != b.object || a.isExit != b.isExit ||
                a.normal.dot(b.normal) < kSameWay)
                continue;
            const std::pair<Key, Key> pair(keyOf(_parts[i]), keyOf(_parts[j]));
            const bool wasOne = std::find(_joined.begin(), _joined.end(), pair) != _joined.end();
            if ((a.centre - b.centre).norm() >= (wasOne ? _options.part_m : _options.join_m))
                continue;
            pairs.push_back(pair);
            const std::size_t from = group[j], to = group[i];
            std::replace(group.begin(), group.end(), from, to);
        }
    _joined = std::move(pairs);
    _normals.clear();
    for (const Part& part : _parts)
        _normals.emplace_back(keyOf(part), part.patch.normal);
    for (std::size_t i = 0; i < count; ++i)
    {
        std::vector<const Part*> members;
        for (std::size_t j = 0; j < count; ++j)
            if (group[j] == i) members.push_back(&_parts[j]);
        if (!members.empty()) _patches.push_back(joined(members));
    }
    _parts.clear();
}

} // namespace midair::bridge
