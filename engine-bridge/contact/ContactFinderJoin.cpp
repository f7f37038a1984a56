#include "engine-bridge/contact/ContactFinder.h"
#include "engine-bridge/hands/SegmentDistance.h"

#include <algorithm>
#include <numeric>

namespace midair::bridge
{

namespace
{

/// Patches that look farther apart than this aren't one, whatever their distance.
constexpr double kSameWay = 0.5; // 60 degrees

bool overlap(const Capsule& a, const Capsule& b)
{
    return closestSegments(a.a, a.b, b.a, b.b).distance < a.radius_m + b.radius_m;
}

} // namespace

// What overlaps is summed anew over the union, so that no part of the surface counts twice.
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
