// Shapes that a subtree had before and may have again, as the children of an osg::Sequence: they
// keep their meshes, and so their samples.

#include "engine-bridge/scene/MeshCache.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

// Keeps what the subtree is, before it becomes \a next.
void MeshCache::keepShape(Subtree& subtree, const SubtreeState& next) const
{
    const std::vector<Part>& parts = subtree.shape.parts;
    if (parts.empty() || subtree.isRepainted || parts.front().bytes > kKeptBytes ||
        subtree.shape.fingerprint.topology == next.fingerprint().topology)
        return;
    if (subtree.kept.size() >= kKeptShapes)
        subtree.kept.erase(std::min_element(subtree.kept.begin(),
                                            subtree.kept.end(),
                                            [](const KeptShape& a, const KeptShape& b)
                                            { return a.used < b.used; }));
    subtree.kept.push_back({subtree.shape, _frame});
}

// Returns true if the subtree is again what it was before, which it then takes back.
bool MeshCache::recallShape(Subtree& subtree) const
{
    const MeshFingerprint now = subtree.next.fingerprint();
    const auto same =
        std::find_if(subtree.kept.begin(),
                     subtree.kept.end(),
                     [&now](const KeptShape& kept) { return kept.shape.fingerprint == now; });
    if (same == subtree.kept.end()) return false;
    std::swap(same->shape, subtree.shape);
    same->used = _frame;
    subtree.now = subtree.next;
    return true;
}

void MeshCache::forgetShapes(Subtree& subtree) const
{
    const auto isOld = [this](const KeptShape& kept) { return _frame - kept.used > kKeptFrames; };
    subtree.kept.erase(std::remove_if(subtree.kept.begin(), subtree.kept.end(), isOld),
                       subtree.kept.end());
}

} // namespace midair::bridge
