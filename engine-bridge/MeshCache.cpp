#include "engine-bridge/MeshCache.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{
constexpr std::size_t kManyStretches = 8;
}

void MeshCache::beginFrame()
{
    for (auto& [root, subtree] : _subtrees)
    {
        subtree.checked = false;
        for (Stretched& s : subtree.stretched)
            ++s.unusedFrames;
    }
}

void MeshCache::refresh(Subtree& subtree,
                        osg::Node& root,
                        const ExtractOptions& options,
                        std::vector<std::string>& warnings)
{
    subtree.checked = true;
    const bool fresh = !subtree.root;
    if (!fresh && subtree.intensityFromColors == options.intensityFromColors &&
        fingerprint(root, options) == subtree.extracted.fingerprint)
        return;

    const std::uint64_t oldTopology = subtree.extracted.fingerprint.topology;
    subtree.root = &root;
    subtree.intensityFromColors = options.intensityFromColors;
    subtree.extracted = extractMesh(root, options);
    subtree.stretched.clear();
    ++_extractions;
    if (fresh || oldTopology != subtree.extracted.fingerprint.topology)
    {
        subtree.topologyId = _nextId++;
        warnings.insert(
            warnings.end(), subtree.extracted.warnings.begin(), subtree.extracted.warnings.end());
    }
}

CachedMesh MeshCache::get(osg::Node& root,
                          const Eigen::Matrix3d& stretch,
                          const ExtractOptions& options,
                          std::vector<std::string>& warnings)
{
    Subtree& subtree = _subtrees[&root];
    if (!subtree.checked) refresh(subtree, root, options, warnings);

    auto same = [&stretch](const Stretched& s) { return s.stretch.isApprox(stretch, 1e-6); };
    auto found = std::find_if(subtree.stretched.begin(), subtree.stretched.end(), same);
    if (found == subtree.stretched.end())
    {
        // While an object is being scaled every frame brings a stretch that never comes back.
        if (subtree.stretched.size() >= kManyStretches) forgetUnused(subtree, 1);
        auto mesh = std::make_shared<haptics::TriangleMesh>(subtree.extracted.mesh);
        mesh->vertices = stretch * mesh->vertices;
        subtree.stretched.push_back({stretch, {_nextId++, subtree.topologyId, mesh}, 0});
        found = std::prev(subtree.stretched.end());
    }
    found->unusedFrames = 0;
    return found->cached;
}

void MeshCache::endFrame()
{
    for (auto subtree = _subtrees.begin(); subtree != _subtrees.end();)
    {
        forgetUnused(subtree->second, kKeptFrames);
        subtree = subtree->second.stretched.empty() ? _subtrees.erase(subtree) : std::next(subtree);
    }
}

void MeshCache::forgetUnused(Subtree& subtree, int frames)
{
    auto old = [frames](const Stretched& s) { return s.unusedFrames > frames; };
    auto& all = subtree.stretched;
    all.erase(std::remove_if(all.begin(), all.end(), old), all.end());
}

} // namespace midair::bridge
