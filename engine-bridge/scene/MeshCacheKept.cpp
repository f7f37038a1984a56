// How long meshes are kept. Shapes that a subtree had before and may have again, as the children of
// an osg::Sequence, keep their meshes, and so their samples.

#include "engine-bridge/scene/MeshCache.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr std::uint64_t kSweepFrames = 60;

} // namespace

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

void MeshCache::endFrame()
{
    if (_frame % kKeptFrames == 0) _spares->forgetUnused();
    if (_frame % kSweepFrames != 0) return;
    _bin->freeUnused();
    bool forgotten = false;
    for (auto subtree = _subtrees.begin(); subtree != _subtrees.end();)
    {
        for (Part& part : subtree->second.shape.parts)
        {
            // A caller for whom look() stays the same holds the mesh without asking again.
            for (Stretched& s : part.stretched)
                if (s.mesh.useCount() > 1) s.used = _frame;
            forgetUnused(part, kKeptFrames);
        }
        forgetShapes(subtree->second);
        const bool unused = _frame - subtree->second.used > kKeptFrames;
        forgotten = forgotten || unused;
        subtree = unused ? _subtrees.erase(subtree) : std::next(subtree);
    }
    if (forgotten) _images.forgetUnused();
}

void MeshCache::forgetUnused(Part& part, std::uint64_t frames) const
{
    auto old = [&](const Stretched& s)
    { return _frame - s.used > frames && s.mesh.useCount() == 1; };
    auto& all = part.stretched;
    all.erase(std::remove_if(all.begin(), all.end(), old), all.end());
}

} // namespace midair::bridge
